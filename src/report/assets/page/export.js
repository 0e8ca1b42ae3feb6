// A chart as a picture, and the rows of its window as CSV.

function saveNumbers(chart) {
  chart.load().then(() => {
    const axis = chart.axis, head = [axis.column], rows = new Map();  // by their place on the axis
    chart.spec.curves.forEach((c, k) => {
      const {x, value, sigma, low, high} = chart.curve(k), at = head.length;
      head.push(c.label);
      const columns = [value];
      for (const [kind, column] of [['sigma', sigma], ['least', low], ['most', high]]) {
        if (column) { head.push(`${kind}_${c.label}`); columns.push(column); }
      }
      for (let i = lower(x, axis.view[0]); i < x.length && x[i] <= axis.view[1]; i++) {
        if (!rows.has(x[i])) rows.set(x[i], []);
        columns.forEach((column, n) => { rows.get(x[i])[at + n] = column[i]; });
      }
    });
    const cell = v => Number.isFinite(v) ? Number(v.toPrecision(12)) : '';
    const lines = [...rows.keys()].sort((a, b) => a - b).map(x => [axis.columnText(x)].concat(Array.from({length: head.length - 1}, (_, k) => cell(rows.get(x)[k + 1]))).join(','));
    save(new Blob([[head.join(',')].concat(lines).join('\n') + '\n'], {type: 'text/csv'}), fileName(chart, 'csv'));
  });
}

function fileName(chart, end) { return chart.spec.name.replace(/[^a-z0-9]+/gi, '_').replace(/^_|_$/g, '') + '.' + end; }

function savePicture(chart) {
  if (!chart.graph) return;
  const scale = 2, box = chart.box.getBoundingClientRect(), top = 26, canvas = document.createElement('canvas');
  canvas.width = box.width * scale;
  canvas.height = (box.height + top) * scale;
  const context = canvas.getContext('2d');
  context.scale(scale, scale);
  context.fillStyle = ground;
  context.fillRect(0, 0, box.width, box.height + top);
  context.fillStyle = ink;
  context.font = 'bold 13px sans-serif';
  context.fillText(chart.spec.title + (chart.spec.unit ? ` [${chart.spec.unit}]` : ''), 8, 17);
  let left = 16 + context.measureText(chart.spec.title + (chart.spec.unit ? ` [${chart.spec.unit}]` : '')).width;
  context.font = '12px sans-serif';
  if (chart.spec.curves.length > 1) {
    chart.spec.curves.forEach((c, k) => {
      context.fillStyle = chart.colour(k);
      context.fillText(c.label, left, 17);
      left += context.measureText(c.label).width + 12;
    });
  }
  context.fillStyle = ink;
  for (const layer of chart.box.querySelectorAll('canvas')) {
    const at = layer.getBoundingClientRect();
    context.drawImage(layer, at.left - box.left, at.top - box.top + top, at.width, at.height);
  }
  context.font = '11px sans-serif';
  context.textBaseline = 'middle';
  for (const label of chart.box.querySelectorAll('.dygraph-axis-label')) {
    const at = label.getBoundingClientRect(), right = label.classList.contains('dygraph-axis-label-y');
    context.textAlign = right ? 'right' : 'center';
    context.fillText(label.textContent, right ? at.right - box.left : (at.left + at.right) / 2 - box.left, (at.top + at.bottom) / 2 - box.top + top);
  }
  canvas.toBlob(blob => save(blob, fileName(chart, 'png')));
}

function save(blob, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
