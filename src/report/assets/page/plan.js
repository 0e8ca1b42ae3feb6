// The plan of the track, with pan and zoom, its fixes, and the place of the cursor.

function ramp(u) {  // viridis, by a few of its colours
  const stops = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
  const at = Math.min(0.9999, Math.max(0, u)) * (stops.length - 1), k = Math.floor(at), f = at - k;
  return `rgb(${stops[k].map((c, i) => Math.round(c + f * (stops[k + 1][i] - c))).join()})`;
}

// World coordinates to latitude and longitude, for a map below the plan.
function geodetic(north, east) {
  const [latitude, longitude, height] = page.origin, d = Math.PI / 180, a = 6378137, e2 = 0.00669437999014;
  const s = Math.sin(latitude * d), c = Math.cos(latitude * d), sl = Math.sin(longitude * d), cl = Math.cos(longitude * d), n = a / Math.sqrt(1 - e2 * s * s);
  const down = -(north * north + east * east) / (2 * a);  // the ellipsoid falls away from the plane
  const x = (n + height) * c * cl - s * cl * north - sl * east + c * cl * down, y = (n + height) * c * sl - s * sl * north + cl * east + c * sl * down;
  const z = (n * (1 - e2) + height) * s + c * north + s * down, p = Math.hypot(x, y);
  let b = Math.atan2(z, p * (1 - e2));
  for (let k = 0; k < 4; k++) b = Math.atan2(z + e2 * a / Math.sqrt(1 - e2 * Math.sin(b) ** 2) * Math.sin(b), p);
  return [b / d, Math.atan2(y, x) / d];
}

let plan = null;
function makePlan() {
  const box = byId('plan');
  if (!box || !page.origin) return;
  let mapped = false, map = null, at = () => null, layer = null;
  const marker = document.createElement('div');
  marker.className = 'plan-cursor';

  const Canvas = L.Layer.extend({
    onAdd(m) {
      this.canvas = L.DomUtil.create('canvas', '', m.getPane('overlayPane'));
      m.on('move zoom viewreset resize', this.draw, this);
      this.draw();
    },
    onRemove(m) { this.canvas.remove(); m.off('move zoom viewreset resize', this.draw, this); },
    draw() { paint(this.canvas); },
  });

  function colouring() {
    const kind = byId('colour').value, track = tables[which];
    if (kind === 'time') return {values: track.x.map(t => t - page.start), unit: 's'};
    if (kind === 'height') return {values: track.column('height_m'), unit: 'm'};
    if (kind === 'sigma') return {values: valuesOf(which, 'hypot:sigma_north_m,sigma_east_m', 0), unit: 'm'};
    if (kind === 'quality') return {values: recentShare(track.x), unit: 'share of fixes used'};
    if (kind === 'solution') return {values: ofLastFix(track.x, 'quality'), kinds: qualities, colours: qualityColour};
    if (kind === 'satellites') return {values: ofLastFix(track.x, 'satellites'), unit: 'satellites'};
    const speed = valuesOf(which, 'hypot:velocity_north_m_s,velocity_east_m_s,velocity_down_m_s', 0);
    if (!speed.some(Number.isFinite)) return {values: track.x.map(t => t - page.start), unit: 's'};
    return {values: speed, unit: 'm/s'};
  }
  // Share of the last ten fixes that were used.
  function recentShare(times) {
    const out = new Float64Array(times.length), last = [];
    let k = 0, sum = 0;
    for (let i = 0; i < times.length; i++) {
      for (; k < measured.length && measured[k].time <= times[i]; k++) {
        last.push(measured[k].used ? 1 : 0);
        sum += last[last.length - 1];
        if (last.length > 10) sum -= last.shift();
      }
      out[i] = last.length ? sum / last.length : 0;
    }
    return out;
  }

  // What the last fix before each time had.
  function ofLastFix(times, name) {
    const out = new Float64Array(times.length);
    let k = 0, last = NaN;
    for (let i = 0; i < times.length; i++) {
      for (; k < measured.length && measured[k].time <= times[i]; k++) if (Number.isFinite(measured[k][name])) last = measured[k][name];
      out[i] = last;
    }
    return out;
  }

  let points = null;  // in the map's unit at zoom 0
  function project() {
    const track = tables[which], north = track.column('north_m'), east = track.column('east_m');
    const one = (n, e) => map.project(at(n, e), 0);
    const of = (count, n, e) => {
      const x = new Float64Array(count), y = new Float64Array(count);
      for (let i = 0; i < count; i++) { const p = one(n(i), e(i)); x[i] = p.x; y[i] = p.y; }
      return {x, y};
    };
    points = {track: of(track.rows, i => north[i], i => east[i]), fixes: of(measured.length, i => measured[i].north, i => measured[i].east)};
  }

  function paint(canvas) {
    const size = map.getSize(), scale = window.devicePixelRatio || 1, context = canvas.getContext('2d');
    canvas.width = size.x * scale;
    canvas.height = size.y * scale;
    canvas.style.width = size.x + 'px';
    canvas.style.height = size.y + 'px';
    L.DomUtil.setPosition(canvas, map.containerPointToLayerPoint([0, 0]));
    context.scale(scale, scale);
    const zoom = map.getZoomScale(map.getZoom(), 0), corner = map.getPixelBounds().min;
    const X = x => x * zoom - corner.x, Y = y => y * zoom - corner.y;
    const outside = (x, y) => x < -20 || y < -20 || x > size.x + 20 || y > size.y + 20;
    const {values, unit, kinds, colours} = colouring(), track = tables[which], times = track.x, view = time.view, {x: tx, y: ty} = points.track;
    let low = Infinity, high = -Infinity;
    for (const v of values) { if (v < low) low = v; if (v > high) high = v; }
    if (byId('ellipses-shown').checked) {
      const sn = track.column('sigma_north_m'), se = track.column('sigma_east_m'), metre = pixelsAMetre();
      context.strokeStyle = dark ? 'rgba(230,237,243,.45)' : 'rgba(36,41,47,.4)';
      let lastX = -1e9, lastY = -1e9;
      for (let i = 0; i < track.rows; i++) {
        const x = X(tx[i]), y = Y(ty[i]);
        if (outside(x, y) || Math.hypot(x - lastX, y - lastY) < 22) continue;
        lastX = x; lastY = y;
        context.beginPath();
        context.ellipse(x, y, Math.max(0.5, se[i] * metre), Math.max(0.5, sn[i] * metre), 0, 0, 2 * Math.PI);
        context.stroke();
      }
    }
    const drawFixes = wanted => {  // those that were used lie below the track
      if (!byId('fixes-shown').checked) return;
      const {x: fx, y: fy} = points.fixes;
      measured.forEach((fix, i) => {
        if (!wanted(fix)) return;
        const x = X(fx[i]), y = Y(fy[i]);
        if (!outside(x, y)) mark(context, x, y, fix, kinds && colours[fix.quality]);
      });
    };
    drawFixes(fix => fix.used);
    context.lineWidth = 2.6;
    context.lineCap = 'round';
    let px = NaN, py = NaN, colour = '', open = false;
    const last = track.rows - 1;
    for (let i = 0; i <= last; i++) {
      const x = X(tx[i]), y = Y(ty[i]);
      if (i > 0 && i < last && Math.abs(x - px) < 1.2 && Math.abs(y - py) < 1.2) continue;
      const now = times[i] < view[0] || times[i] > view[1] ? (dark ? '#4a535d' : '#c8ced4') :
        kinds ? colours[values[i]] || colours[0] : ramp((values[i] - low) / (high - low || 1));
      if (now !== colour || !open) {
        if (open) context.stroke();
        context.beginPath();
        context.strokeStyle = colour = now;
        if (i > 0) context.moveTo(px, py);
        open = true;
      }
      if (!(outside(x, y) && outside(px, py))) context.lineTo(x, y); else context.moveTo(x, y);
      px = x; py = y;
    }
    if (open) context.stroke();
    for (const [list, shade] of [[page.outages, dark ? '#ff6b6b' : '#d1242f'], [page.rest, dark ? '#9cc7f0' : '#3c6ea0']]) {
      for (const [start, end] of list) {
        context.strokeStyle = shade;
        context.lineWidth = 1;
        context.beginPath();
        for (let i = lower(times, start); i < times.length && times[i] <= end; i++) context.lineTo(X(tx[i]), Y(ty[i]));
        context.stroke();
      }
    }
    drawFixes(fix => !fix.used);
    for (const [i, text, below] of [[0, 'start', 0], [last, 'end', 18]]) {
      const x = X(tx[i]), y = Y(ty[i]);
      context.fillStyle = ink;
      context.beginPath();
      context.arc(x, y, 4, 0, 2 * Math.PI);
      context.fill();
      context.font = 'bold 12px sans-serif';
      context.lineWidth = 3;
      context.strokeStyle = ground;
      context.strokeText(text, x + 7, y - 5 + below);
      context.fillText(text, x + 7, y - 5 + below);
    }
    legend(low, high, unit, kinds && kinds.map((name, k) => ({name, colour: colours[k]})).filter((_, k) => values.includes(k)));
    place();
  }
  function mark(context, x, y, fix, kind) {
    const colour = fix.outcome === 0 && kind || outcomeColour[fix.outcome];
    context.strokeStyle = context.fillStyle = colour;
    context.lineWidth = 1.4;
    context.beginPath();
    if (fix.outcome === 0) {
      if (fix.velocity) return;  // below that of its position
      context.arc(x, y, 2.5, 0, 2 * Math.PI);
      context.globalAlpha = 0.5;
      context.fill();
      context.globalAlpha = 1;
      return;
    }
    if (fix.outcome === 1) { context.moveTo(x - 4, y - 4); context.lineTo(x + 4, y + 4); context.moveTo(x + 4, y - 4); context.lineTo(x - 4, y + 4); }
    else if (fix.outcome === 2) context.arc(x, y, 4, 0, 2 * Math.PI);
    else if (fix.outcome === 3) { context.moveTo(x, y - 5); context.lineTo(x + 5, y + 4); context.lineTo(x - 5, y + 4); context.closePath(); }
    else context.rect(x - 3, y - 3, 6, 6);
    context.stroke();
  }
  function pixelsAMetre() {
    const a = map.latLngToContainerPoint(at(0, 0)), b = map.latLngToContainerPoint(at(1000, 0));
    return Math.hypot(a.x - b.x, a.y - b.y) / 1000;
  }
  function legend(low, high, unit, kinds) {
    const there = new Set(measured.map(fix => fix.outcome)), signs = ['·', '×', '○', '△', '□'], out = byId('scale');
    out.textContent = '';
    const bar = document.createElement('span');
    bar.className = 'ramp';
    bar.style.background = `linear-gradient(90deg, ${[0, 0.25, 0.5, 0.75, 1].map(ramp).join()})`;
    const text = v => v.toFixed(Math.max(0, Math.min(6, 2 - Math.floor(Math.log10(high - low || 1)))));
    if (kinds) {
      for (const {name, colour} of kinds) {
        const sign = document.createElement('span');
        sign.style.color = colour;
        sign.textContent = '▬ ';
        out.append(sign, name);
      }
    } else {
      out.append(text(low) + ' ', bar, ` ${text(high)} ${unit}`);
    }
    outcomes.forEach((name, k) => {
      if (!there.has(k)) return;
      const sign = document.createElement('span');
      sign.style.color = outcomeColour[k];
      sign.textContent = `${signs[k]} `;
      out.append(sign, name);
    });
  }
  // The place of the cursor's time.
  function place() {
    const cursor = time.cursor, shown = cursor !== null && map;
    marker.hidden = !shown;
    if (!shown) return;
    const track = tables[which], i = nearest(track.x, cursor), zoom = map.getZoomScale(map.getZoom(), 0), corner = map.getPixelBounds().min;
    marker.style.left = points.track.x[i] * zoom - corner.x + 'px';
    marker.style.top = points.track.y[i] * zoom - corner.y + 'px';
  }
  // The time of the place next to the pointer.
  function findTime(event) {
    const zoom = map.getZoomScale(map.getZoom(), 0), corner = map.getPixelBounds().min, p = event.containerPoint, {x, y} = points.track;
    const times = tables[which].x, view = time.view;
    let best = -1, least = 30 * 30;
    for (let i = 0; i < x.length; i++) {
      if (times[i] < view[0] || times[i] > view[1]) continue;
      const dx = x[i] * zoom - corner.x - p.x, dy = y[i] * zoom - corner.y - p.y, square = dx * dx + dy * dy;
      if (square < least) { least = square; best = i; }
    }
    if (best >= 0) time.point(times[best]);
  }

  function open(tilesAddress) {
    if (map) map.remove();
    mapped = !!tilesAddress;
    at = mapped ? (n, e) => L.latLng(geodetic(n, e)) : (n, e) => L.latLng(n, e);
    map = L.map(box, {crs: mapped ? L.CRS.EPSG3857 : L.CRS.Simple, zoomAnimation: false, fadeAnimation: false, inertia: false, zoomSnap: 0,
      zoomDelta: 0.5, minZoom: mapped ? 1 : -20, maxZoom: mapped ? 26 : 16, attributionControl: false, scrollWheelZoom: true, wheelPxPerZoomLevel: 120});
    if (mapped) L.tileLayer(tilesAddress, {maxZoom: 26, maxNativeZoom: 19}).addTo(map);
    const track = tables[which], north = track.column('north_m'), east = track.column('east_m');
    let bounds = [Infinity, Infinity, -Infinity, -Infinity];
    for (let i = 0; i < track.rows; i++) {
      bounds = [Math.min(bounds[0], north[i]), Math.min(bounds[1], east[i]), Math.max(bounds[2], north[i]), Math.max(bounds[3], east[i])];
    }
    const margin = 0.5 + 0.02 * Math.max(bounds[2] - bounds[0], bounds[3] - bounds[1]);
    map.fitBounds(L.latLngBounds(at(bounds[0] - margin, bounds[1] - margin), at(bounds[2] + margin, bounds[3] + margin)));
    project();
    layer = new Canvas().addTo(map);
    L.control.scale({imperial: false, maxWidth: 120}).addTo(map);
    map.on('mousemove click', findTime);
    box.append(marker);
  }
  collectFixes();
  for (const [name, value, text] of [['quality', 'solution', 'kind of fix'], ['satellites', 'satellites', 'satellites']]) {
    if (measured.some(fix => Number.isFinite(fix[name]))) byId('colour').add(new Option(text, value));
  }
  open('');
  let viewDrawn = time.view;
  time.listeners.push(() => { if (viewDrawn !== time.view) { viewDrawn = time.view; layer.draw(); } else place(); });
  for (const id of ['colour', 'fixes-shown', 'ellipses-shown']) byId(id).addEventListener('change', () => layer.draw());
  byId('tiles-on').addEventListener('click', () => open(byId('tiles').value.trim()));
  new ResizeObserver(() => map.invalidateSize({animate: false})).observe(box);
  plan = {changed() { collectFixes(); project(); layer.draw(); }};
}
