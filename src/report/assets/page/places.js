// Pictures of places along an axis, such as the plan of a course: they show its cursor, and set it.

async function showPlaces(spec) {
  const picture = document.querySelector(`[data-places="${spec.name}"] svg`), axis = axes[spec.axis];
  if (!picture) return;
  const lines = spec.lines.map(line => tables[line.table]), dots = [];
  for (const [k, line] of lines.entries()) {
    await line.load();
    const dot = document.createElementNS('http://www.w3.org/2000/svg', 'circle');
    for (const [name, value] of [['r', 6], ['class', 'at'], ['fill', palette[spec.lines[k].colour]], ['visibility', 'hidden']]) dot.setAttribute(name, value);
    dots.push(picture.appendChild(dot));
  }
  axis.listeners.push(() => dots.forEach((dot, k) => {
    const {cursor} = axis, line = lines[k], i = cursor === null ? 0 : nearest(line.x, cursor);
    dot.setAttribute('cx', line.column('right')[i]);
    dot.setAttribute('cy', line.column('down')[i]);
    dot.setAttribute('visibility', cursor === null || cursor < axis.whole[0] || cursor > axis.whole[1] ? 'hidden' : 'visible');
  }));
  picture.addEventListener('pointermove', event => {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(picture.getScreenCTM().inverse());
    let least = Infinity, found = null;
    for (const line of lines) {
      const right = line.column('right'), down = line.column('down');
      for (let i = 0; i < line.rows; i++) {
        const far = Math.hypot(right[i] - at.x, down[i] - at.y);
        if (far < least) [least, found] = [far, line.x[i]];
      }
    }
    if (found !== null) axis.point(found);
  });
}
