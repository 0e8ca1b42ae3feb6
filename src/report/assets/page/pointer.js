// What mouse and fingers do in a chart.

// Drag: a box, or along one axis. Wheel with Ctrl, or after a click: zoom about the pointer. Shift and drag: pan. Two fingers: zoom.
function interaction(chart) {
  const nearlyFlat = 12, axis = chart.axis;
  let from = null, box = null, wheel = false;
  const fingers = new Map();
  const place = event => {
    const r = chart.box.getBoundingClientRect();
    return [event.clientX - r.left, event.clientY - r.top];
  };
  const finish = (a, b) => {
    const g = chart.graph, dx = Math.abs(b[0] - a[0]), dy = Math.abs(b[1] - a[1]);
    if (dx < 3 && dy < 3) { wheel = true; return; }
    const times = [g.toDataXCoord(Math.min(a[0], b[0])), g.toDataXCoord(Math.max(a[0], b[0]))];
    if (dy >= nearlyFlat || dy > dx) {
      chart.yWindow = [g.toDataYCoord(Math.max(a[1], b[1])), g.toDataYCoord(Math.min(a[1], b[1]))];
      chart.stale = true;
    }
    if (dx >= nearlyFlat || dx > dy) axis.show(...times); else axis.drawVisible();
  };
  const pinch = () => {
    const [a, b] = [...fingers.values()];
    const g = chart.graph, left = Math.min(a.x, b.x), right = Math.max(a.x, b.x), area = g.getArea();
    if (right - left < 10) return;
    // The times that were under the fingers stay under them.
    const t0 = Math.min(a.t, b.t), t1 = Math.max(a.t, b.t), scale = (t1 - t0) / (right - left), start = t0 - (left - area.x) * scale;
    axis.show(start, start + area.w * scale);
  };
  const model = {
    pointerdown(event) {
      const at = place(event);
      chart.box.setPointerCapture(event.pointerId);
      if (event.pointerType === 'touch') fingers.set(event.pointerId, {x: at[0], t: chart.graph.toDataXCoord(at[0])});
      from = {at, view: axis.view.slice(), pan: event.shiftKey || event.pointerType === 'touch'};
      if (from.pan) return;
      box = document.createElement('div');
      box.className = 'zoom-box';
      chart.box.append(box);
    },
    pointermove(event) {
      const at = place(event);
      if (!from) { axis.point(chart.graph.toDataXCoord(at[0])); return; }
      if (fingers.has(event.pointerId)) fingers.get(event.pointerId).x = at[0];
      if (fingers.size === 2) return pinch();
      if (from.pan) {
        const area = chart.graph.getArea(), shift = (from.at[0] - at[0]) * (from.view[1] - from.view[0]) / area.w;
        if (event.pointerType === 'touch' && fingers.size === 1 && Math.abs(from.at[0] - at[0]) < 4) axis.point(chart.graph.toDataXCoord(at[0]));
        else axis.show(from.view[0] + shift, from.view[1] + shift);
        return;
      }
      const area = chart.graph.getArea(), dx = Math.abs(at[0] - from.at[0]), dy = Math.abs(at[1] - from.at[1]);
      const alongX = dy < nearlyFlat && dx >= dy, alongY = dx < nearlyFlat && dy > dx;
      const [left, right] = alongY ? [area.x, area.x + area.w] : [Math.min(at[0], from.at[0]), Math.max(at[0], from.at[0])];
      const [top, bottom] = alongX ? [area.y, area.y + area.h] : [Math.min(at[1], from.at[1]), Math.max(at[1], from.at[1])];
      Object.assign(box.style, {left: left + 'px', top: top + 'px', width: right - left + 'px', height: bottom - top + 'px'});
    },
    pointerup(event) {
      fingers.delete(event.pointerId);
      if (box) {
        box.remove();
        box = null;
        finish(from.at, place(event));
      }
      from = null;
    },
    pointercancel(event) { fingers.delete(event.pointerId); if (box) box.remove(); box = from = null; },
    pointerleave() { wheel = false; },
    wheel(event) {
      if (!wheel && !event.ctrlKey && !event.metaKey) return;
      event.preventDefault();
      const factor = Math.exp(0.0015 * event.deltaY), t = chart.graph.toDataXCoord(place(event)[0]);
      axis.show(t - (t - axis.view[0]) * factor, t + (axis.view[1] - t) * factor);
    },
    dblclick() { axis.reset(); },
  };
  // Not through the library, whose listeners are of the mouse.
  for (const [name, act] of Object.entries(model)) chart.box.addEventListener(name, act, {passive: false});
  return {};
}
