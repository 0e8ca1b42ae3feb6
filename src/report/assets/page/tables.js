// Tables: inflated once, a column decoded when it is asked for, and what is derived from columns.

async function inflated(text) {
  const bytes = atob(text), raw = new Uint8Array(bytes.length);
  for (let i = 0; i < raw.length; i++) raw[i] = bytes.charCodeAt(i);
  const stream = new Blob([raw]).stream().pipeThrough(new DecompressionStream('deflate-raw'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

class Table {
  constructor(spec) {
    this.rows = spec.rows;
    this.spec = spec;
    this.columns = new Map();
    this.info = new Map(spec.columns.map(c => [c.name, c]));
  }
  load() {
    return this.loading ??= inflated(this.spec.data).then(bytes => { this.bytes = bytes; this.spec.data = null; });
  }
  get ready() { return !!this.bytes; }
  get x() { return this.column(this.has('time_s') ? 'time_s' : 'x'); }
  has(name) { return this.info.has(name); }
  column(name) {
    if (!this.columns.has(name)) this.columns.set(name, this.decode(this.info.get(name)));
    return this.columns.get(name);
  }
  decode({step, log, order, at}) {
    const out = new Float64Array(this.rows), before = [0, 0, 0], bytes = this.bytes;
    for (let i = 0; i < this.rows; i++) {
      let number = 0, weight = 1, byte;
      do {
        byte = bytes[at++];
        number += (byte & 127) * weight;
        weight *= 128;
      } while (byte & 128);
      if (number === 0) { out[i] = NaN; continue; }
      number -= 1;
      let value = number % 2 ? -(number + 1) / 2 : number / 2;
      for (let k = order - 1; k >= 0; k--) before[k] = value += before[k];
      out[i] = log ? Math.exp(value * step) : value * step;
    }
    return out;
  }
}

const tables = {};
for (const [name, spec] of Object.entries(page.tables)) tables[name] = new Table(spec);
let which = tables.smoothed ? 'smoothed' : tables.filtered ? 'filtered' : 'track';
const tableName = name => name === 'solution' ? which : name === 'biases' ? 'biases_' + which : name;

// Index of the first time at or after t.
function lower(times, t) {
  let low = 0, high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] < t) low = middle + 1; else high = middle;
  }
  return low;
}
function nearest(times, t) {
  const i = lower(times, t);
  return i > 0 && (i === times.length || t - times[i - 1] < times[i] - t) ? i - 1 : i;
}

// Values less their mean over a part of the run; angles are unwrapped first.
function lessRunningMean(times, values, turn) {
  const n = values.length, half = Math.max(2, Math.round(n / 400)), sum = new Float64Array(n + 1), out = new Float64Array(n);
  let turns = 0;
  for (let i = 0; i < n; i++) {
    if (turn && i > 0) turns += Math.round((values[i - 1] - values[i]) / turn);
    out[i] = values[i] + turns * turn;
    sum[i + 1] = sum[i] + out[i];
  }
  for (let i = 0; i < n; i++) {
    const reach = Math.min(half, i, n - 1 - i);  // as many rows on either side: no slope is left at the ends
    out[i] -= (sum[i + reach + 1] - sum[i - reach]) / (2 * reach + 1);
  }
  return out;
}

// A column, or what page_data.h derives from columns.
const derived = new Map();
function valuesOf(table, expression, turn) {
  const colon = expression.indexOf(':');
  if (colon < 0) return tables[table].column(expression);
  const key = table + ' ' + expression;
  if (derived.has(key)) return derived.get(key);
  const kind = expression.slice(0, colon), names = expression.slice(colon + 1).split(',');
  let out;
  if (tables[kind]) {
    out = tables[kind].column(names[0]);
  } else if (kind === 'change') {
    const a = tables.filtered.column(names[0]), b = tables.smoothed.column(names[0]);
    out = a.map((v, i) => turn ? v - b[i] - turn * Math.round((v - b[i]) / turn) : v - b[i]);
  } else {
    const parts = names.map(name => tables[table].column(name));
    if (kind === 'hypot') out = parts[0].map((_, i) => Math.hypot(...parts.map(p => p[i])));
    if (kind === 'over') out = parts[0].map((v, i) => v / parts[1][i]);
    if (kind === 'detail') out = lessRunningMean(tables[table].x, parts[0], turn);
  }
  derived.set(key, out);
  return out;
}
