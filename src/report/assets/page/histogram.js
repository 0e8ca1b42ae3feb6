// Histograms of residuals in sigmas, next to their chart.

function histogram(chart) {
  const [low, high, width] = [-5, 5, 0.25], bins = Math.round((high - low) / width), size = [220, 170], parts = [];
  chart.spec.curves.forEach((c, k) => {
    const {value} = chart.curve(k), counts = new Array(bins).fill(0);
    let n = 0, sum = 0, square = 0, beyond = 0;
    for (const v of value) {
      if (!Number.isFinite(v)) continue;
      n++; sum += v; square += v * v;
      if (Math.abs(v) > 1) beyond++;
      counts[Math.min(bins - 1, Math.max(0, Math.floor((v - low) / width)))]++;
    }
    if (n) parts.push({label: c.label, colour: palette[k % palette.length], n, counts, mean: sum / n, std: Math.sqrt(Math.max(0, square / n - (sum / n) ** 2)), beyond: beyond / n});
  });
  if (!parts.length) return;
  const figure = document.createElement('figure'), scale = 2, canvas = document.createElement('canvas'), caption = document.createElement('figcaption');
  figure.className = 'histogram';
  canvas.width = size[0] * scale;
  canvas.height = size[1] * scale;
  canvas.style.width = size[0] + 'px';
  const context = canvas.getContext('2d');
  context.scale(scale, scale);
  const x = v => 8 + (size[0] - 16) * (v - low) / (high - low), top = 0.5, y = density => size[1] - 18 - (size[1] - 26) * Math.min(1, density / top);
  context.strokeStyle = '#8a94a0';
  context.setLineDash([4, 3]);
  context.beginPath();
  for (let v = low; v <= high; v += 0.1) context.lineTo(x(v), y(Math.exp(-v * v / 2) / Math.sqrt(2 * Math.PI)));
  context.stroke();
  context.setLineDash([]);
  for (const part of parts) {
    context.strokeStyle = part.colour;
    context.lineWidth = 1.3;
    context.beginPath();
    part.counts.forEach((count, k) => {
      context.lineTo(x(low + k * width), y(count / part.n / width));
      context.lineTo(x(low + (k + 1) * width), y(count / part.n / width));
    });
    context.stroke();
  }
  context.fillStyle = ink;
  context.font = '11px sans-serif';
  context.textAlign = 'center';
  for (const v of [-4, -2, 0, 2, 4]) context.fillText(String(v), x(v), size[1] - 4);
  caption.textContent = parts.map(p => `${p.label}: mean ${p.mean.toFixed(2)}, std ${p.std.toFixed(2)}, ${(100 * p.beyond).toFixed(0)} % beyond 1`).join('; ') + '. Dashed: as the sigmas say (std 1, 32 %).';
  figure.append(canvas, caption);
  chart.place.after(figure);
}
