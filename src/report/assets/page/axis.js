// Axes: one window and one cursor for all charts over the time, or over what else they stand, such as a frequency.

class Axis {
  constructor({label, unit, log, start, end, shades}) {
    Object.assign(this, {label, unit, log, shades: shades || [], charts: [], listeners: [], cursor: null});
    this.whole = [start, Math.max(end, start + 1e-3)];  // logarithms, if it is logarithmic
    this.view = this.whole.slice();
  }
  show(start, end) {
    const length = Math.max(end - start, 1e-6 * (this.whole[1] - this.whole[0])), middle = (start + end) / 2, whole = this.whole;
    this.view = [middle - length / 2, middle + length / 2];
    if (this.view[0] < whole[0]) this.view = [whole[0], Math.min(whole[1], whole[0] + length)];
    if (this.view[1] > whole[1]) this.view = [Math.max(whole[0], whole[1] - length), whole[1]];
    for (const chart of this.charts) chart.stale = true;
    this.drawVisible();
    for (const listen of this.listeners) listen();
  }
  drawVisible() { for (const chart of this.charts) if (chart.visible && chart.stale) chart.draw(); }
  point(at) {
    this.cursor = at;
    for (const chart of this.charts) chart.point();
    for (const listen of this.listeners) listen();
  }
  reset() {
    for (const chart of this.charts) chart.yWindow = chart.wholeValues();
    this.show(...this.whole);
  }
  // The value that a program is given and a file has, of a place on the axis.
  value(x) { return this.log ? 10 ** x : x; }
  place(value) { return this.log ? Math.log10(value) : value; }
  get column() { return this.label + (this.unit ? ` [${this.unit}]` : ''); }
  columnText(x) { return String(Number(this.value(x).toPrecision(9))); }
  cursorText(x) { return `at ${Number(this.value(x).toPrecision(4))}${this.unit ? ' ' + this.unit : ''}`; }
  ticks(a, b, pixels, options, graph) {
    if (!this.log) return Dygraph.numericTicks(a, b, pixels, options, graph, null);
    const out = [], decades = b - a;
    for (let power = Math.floor(a); power <= Math.ceil(b); power++) {
      for (const digit of decades > 2.5 ? [1] : decades > 1 ? [1, 2, 5] : [1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9]) {
        const v = power + Math.log10(digit);
        if (v >= a && v <= b) out.push({v, label: this.tickText(v)});
      }
    }
    return out;
  }
  tickText(x) { return String(Number(this.value(x).toPrecision(6))); }
}

// The steps between ticks of a clock [s]; below a second they are decimal.
const clockSteps = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 10800, 21600, 43200, 86400];

class TimeAxis extends Axis {
  constructor() {
    super({label: 'time', unit: 's', start: page.start, end: page.end,
      shades: [...page.rest.map(([from, to]) => ({from, to, kind: 'rest'})), ...page.outages.map(([from, to]) => ({from, to, kind: 'outage'}))]});
    this.clock = 'seconds';  // since the start, or `week` or `utc`
    this.listeners.push(() => {
      const out = byId('window');
      if (out) out.textContent = `${this.text(this.view[0], 2)} to ${this.text(this.view[1], 2)}`;
    });
  }
  utc(t) { return new Date(1000 * (page.utc + t)); }
  text(t, digits = 3) {
    if (this.clock === 'utc') return this.utc(t).toISOString().slice(11, digits > 0 ? 23 : 19);
    return (this.clock === 'week' ? t : t - page.start).toFixed(digits);
  }
  get zero() { return this.clock === 'seconds' ? page.start : this.clock === 'utc' ? -(page.utc % 86400) : 0; }
  get column() { return 'time_s'; }
  columnText(t) { return t.toFixed(6); }
  cursorText(t) { return `at ${this.text(t)}${this.clock === 'utc' ? ' UTC' : ' s'}`; }
  ticks(a, b, pixels, options, graph) {
    const from = this.zero, apart = 80;
    if (this.clock === 'utc' && b - a > 5) {
      const wanted = (b - a) * apart / pixels, step = clockSteps.find(s => s >= wanted) || Math.ceil(wanted / 86400) * 86400, out = [];
      for (let k = Math.ceil((a - from) / step); k * step + from <= b; k++) out.push({v: k * step + from, label: this.tickText(k * step + from)});
      return out;
    }
    return Dygraph.numericTicks(a - from, b - from, pixels, options, graph, null).map(tick => {
      const at = tick.v + from;
      return tick.label === undefined ? {...tick, v: at} : {v: at, label: this.tickText(at)};
    });
  }
  tickText(t) {
    if (this.clock !== 'utc') return String(Number((t - this.zero).toFixed(4)));
    const length = this.view[1] - this.view[0], at = this.utc(Math.round(1000 * (page.utc + t)) / 1000 - page.utc).toISOString();
    return length > 900 ? at.slice(11, 16) : at.slice(11, length > 5 ? 19 : 23);
  }
}

const time = new TimeAxis();
const axes = {time};
for (const [name, spec] of Object.entries(page.axes || {})) axes[name] = new Axis(spec);
const charts = [];

const digitsFor = sigma => sigma > 0 ? Math.min(9, Math.max(0, 1 - Math.floor(Math.log10(sigma)))) : 4;
function valueText(value, sigma, unit) {
  if (!Number.isFinite(value)) return '–';
  if (!Number.isFinite(sigma)) return `${Number(value.toPrecision(6))} ${unit}`;
  const digits = digitsFor(sigma);
  return `${value.toFixed(digits)} ± ${sigma.toFixed(digits)} ${unit}`;
}
