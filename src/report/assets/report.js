// Draws plan and charts of a page from the numbers in its element `page-data` (src/report/page_data.h): one cursor and one time window
// for all of them. `window.piste` is how a program drives it.
'use strict';
(function () {
  const page = JSON.parse(document.getElementById('page-data').textContent);
  const dark = matchMedia('(prefers-color-scheme: dark)').matches;
  const palette = dark ? ['#5aaeff', '#ff9350', '#3fc79a', '#e58cc4', '#d8c04a', '#a99cff']
    : ['#0067b8', '#c04f00', '#00805c', '#a8417f', '#8a6d00', '#5b4bc4'];
  const outcomes = ['used', 'rejected', 'readmitted', 'disputed', 'repeated'];
  const outcomeColour = [palette[0], dark ? '#ff6b6b' : '#d1242f', palette[2], palette[3], '#8a94a0'];
  const ink = dark ? '#e6edf3' : '#24292f', ground = dark ? '#14181d' : '#ffffff', rule = dark ? '#3a424b' : '#dde2e7';
  const byId = id => document.getElementById(id);
  const notice = text => { const n = byId('notice'); if (n) { n.textContent = text; n.hidden = false; } };

  // ---- Tables: inflated once, a column decoded when it is asked for.

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
    get time() { return this.column('time_s'); }
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
      if (kind === 'detail') out = lessRunningMean(tables[table].time, parts[0], turn);
    }
    derived.set(key, out);
    return out;
  }

  // ---- One time window and one cursor.

  const whole = [page.start, Math.max(page.end, page.start + 1e-3)];
  let view = whole.slice(), cursor = null;
  const charts = [];
  const listeners = [];

  const leap = 18;  // s: GPS less UTC since 2017
  const gpsEpoch = Date.UTC(1980, 0, 6) / 1000;
  const utcOf = t => new Date(1000 * (gpsEpoch + page.week * 604800 + t - leap));
  let clock = 'seconds';
  function timeText(t, digits = 3) {
    if (clock === 'utc') return utcOf(t).toISOString().slice(11, digits > 0 ? 23 : 19);
    return (clock === 'week' ? t : t - page.start).toFixed(digits);
  }
  const origin = () => clock === 'seconds' ? page.start : clock === 'utc' ? -((gpsEpoch + page.week * 604800 - leap) % 86400) : 0;

  function setView(start, end) {
    const length = Math.max(end - start, 1e-3);
    const middle = (start + end) / 2;
    view = [middle - length / 2, middle + length / 2];
    if (view[0] < whole[0]) view = [whole[0], Math.min(whole[1], whole[0] + length)];
    if (view[1] > whole[1]) view = [Math.max(whole[0], whole[1] - length), whole[1]];
    for (const chart of charts) chart.stale = true;
    drawVisible();
    for (const listen of listeners) listen();
    const out = byId('window');
    if (out) out.textContent = `${timeText(view[0], 2)} to ${timeText(view[1], 2)}`;
  }
  const drawVisible = () => { for (const chart of charts) if (chart.visible && chart.stale) chart.draw(); };

  function setCursor(t) {
    cursor = t;
    for (const chart of charts) chart.point();
    for (const listen of listeners) listen();
  }

  const digitsFor = sigma => sigma > 0 ? Math.min(9, Math.max(0, 1 - Math.floor(Math.log10(sigma)))) : 4;
  function valueText(value, sigma, unit) {
    if (!Number.isFinite(value)) return '–';
    if (!Number.isFinite(sigma)) return `${Number(value.toPrecision(6))} ${unit}`;
    const digits = digitsFor(sigma);
    return `${value.toFixed(digits)} ± ${sigma.toFixed(digits)} ${unit}`;
  }

  // ---- Charts.

  // Rows of a window to draw: all, or in each of `bins` pixel columns those of the least and the largest value; and one row on either side.
  function rowsToDraw(times, values, [start, end], bins) {
    const first = lower(times, start), last = lower(times, end + 1e-9), rows = [];
    if (first > 0) rows.push(first - 1);
    if (last - first <= 2 * bins) {
      for (let i = first; i < last; i++) rows.push(i);
    } else {
      let i = first;
      for (let bin = 1; bin <= bins && i < last; bin++) {
        const until = bin === bins ? last : Math.min(last, lower(times, start + (end - start) * bin / bins));
        let least = -1, most = -1, gap = -1;
        for (; i < until; i++) {
          const v = values[i];
          if (v !== v) { gap = i; continue; }
          if (least < 0 || v < values[least]) least = i;
          if (most < 0 || v > values[most]) most = i;
        }
        const kept = [least, most, least < 0 ? gap : -1].filter(k => k >= 0).sort((a, b) => a - b);
        rows.push(...kept.filter((k, at) => at === 0 || k !== kept[at - 1]));
      }
    }
    if (last < times.length) rows.push(last);
    return rows;
  }

  // A fair part of the rows of a window, at most `most`, and all that `must` be there.
  function rowsToDot(times, [start, end], most, must) {
    const first = lower(times, start), last = lower(times, end + 1e-9), every = Math.ceil((last - first) / most), rows = [];
    let seed = 1;
    for (let begin = first; begin < last; begin += every) {
      seed = (seed * 16807) % 2147483647;
      const stop = Math.min(begin + every, last), chosen = begin + seed % (stop - begin);
      for (let i = begin; i < stop; i++) if (i === chosen || must(i)) rows.push(i);
    }
    return rows;
  }

  class Chart {
    constructor(spec, place) {
      Object.assign(this, {spec, place, stale: true, visible: false, yWindow: null, series: []});
      const heading = document.createElement('div');
      heading.className = 'chart-head';
      const title = document.createElement('b');
      title.textContent = spec.title + (spec.unit ? ` [${spec.unit}]` : '');
      this.legend = document.createElement('span');
      this.legend.className = 'legend';
      const tools = document.createElement('span');
      tools.className = 'chart-tools';
      for (const [text, act] of [['PNG', () => this.savePicture()], ['CSV', () => this.saveNumbers()]]) {
        const button = document.createElement('button');
        button.type = 'button';
        button.textContent = text;
        button.title = `${spec.title} as ${text}`;
        button.addEventListener('click', act);
        tools.append(button);
      }
      heading.append(title, this.legend, tools);
      this.box = document.createElement('div');
      this.box.className = 'chart';
      this.box.setAttribute('role', 'img');
      this.box.setAttribute('aria-label', `${spec.title}${spec.unit ? ' in ' + spec.unit : ''} over time`);
      this.line = document.createElement('div');
      this.line.className = 'cursor';
      place.append(heading, this.box);
    }
    get colours() { return this.spec.colours || palette; }
    tables() {
      const names = [tableName(this.spec.table)];
      for (const c of this.spec.curves) {
        for (const e of [c.value, c.sigma]) {
          if (e && e.startsWith('change:')) names.push('filtered', 'smoothed');
          if (e && tables[e.split(':')[0]]) names.push(e.split(':')[0]);
        }
      }
      return [...new Set(names)].filter(name => tables[name]).map(name => tables[name]);
    }
    load() { return Promise.all(this.tables().map(table => table.load())); }
    get ready() { return this.tables().every(table => table.ready); }

    // The columns of a curve over the whole run.
    curve(k) {
      const c = this.spec.curves[k], name = tableName(this.spec.table), turn = this.spec.turn;
      const value = valuesOf(name, c.value, turn), sigma = c.sigma ? valuesOf(name, c.sigma, 0) : null;
      return {time: tables[name].time, value, sigma, low: c.low ? valuesOf(name, c.low, 0) : null, high: c.high ? valuesOf(name, c.high, 0) : null};
    }

    // What the library is given of one curve: {row, t, value, low, high}, NaN where the line breaks.
    pick(k, bins) {
      const {time, value, sigma, low, high} = this.curve(k), turn = this.spec.turn, wraps = turn && !this.spec.name.includes('_of_');
      const refused = this.refused();
      const rows = this.spec.points ? rowsToDot(time, view, 8000, i => refused[i]) : rowsToDraw(time, value, view, bins);
      const out = {t: [], value: [], low: [], high: []};
      const add = (t, v, l, h) => { out.t.push(t); out.value.push(v); out.low.push(l); out.high.push(h); };
      let before = NaN;
      for (const i of rows) {
        const v = value[i];
        if (wraps && Math.abs(v - before) > turn / 2) add(time[i], NaN, NaN, NaN);
        before = v;
        if (low) add(time[i], v, low[i], high[i]);
        else add(time[i], v, sigma ? v - sigma[i] : v, sigma ? v + sigma[i] : v);
      }
      return out;
    }
    refused() {
      const table = tables[tableName(this.spec.table)];
      return this.spec.points && table.has('outcome') ? table.column('outcome').map(o => o === 1 || o === 3 ? 1 : 0) : [];
    }

    // Joins the curves by time: [time, [low, value, high] …], null where a curve has no row.
    joined() {
      const width = this.box.clientWidth || 600, bins = Math.max(50, Math.floor(width) - 80), count = this.spec.curves.length;
      this.series = this.spec.curves.map((_, k) => this.pick(k, bins));
      const rows = [], at = this.series.map(() => 0);
      for (;;) {
        let t = Infinity;
        this.series.forEach((s, k) => { if (at[k] < s.t.length) t = Math.min(t, s.t[at[k]]); });
        if (t === Infinity) break;
        const row = [t];
        this.series.forEach((s, k) => {
          const i = at[k];
          if (i < s.t.length && s.t[i] === t) {
            at[k]++;
            row.push(this.banded ? [s.low[i], s.value[i], s.high[i]] : s.value[i]);
          } else {
            row.push(this.banded ? [null, null, null] : null);
          }
        });
        rows.push(row);
      }
      if (!rows.length) rows.push([view[0]].concat(Array(count).fill(this.banded ? [null, null, null] : null)));
      return rows;
    }

    draw() {
      if (!this.ready) { this.load().then(() => { if (this.stale) this.draw(); }); return; }
      this.stale = false;
      this.banded = !this.spec.points && this.spec.curves.some(c => c.sigma || c.low);
      const data = this.joined();
      if (!this.graph) return this.create(data);
      this.graph.updateOptions({file: data, dateWindow: view.slice(), valueRange: this.yWindow});
      this.point();
    }

    create(data) {
      const spec = this.spec, series = {};
      const labels = spec.curves.map(c => c.label);
      labels.forEach((label, k) => {
        if (spec.points && label !== 'gate') series[label] = {drawPoints: true, strokeWidth: 0, pointSize: spec.names && label !== 'used' ? 3.5 : 1.7};
        if (label === 'gate') series[label] = {strokeWidth: 1.5, strokePattern: [6, 4], drawPoints: false, color: '#8a94a0'};
      });
      const chart = this;
      this.graph = new Dygraph(this.box, data, {
        labels: ['time'].concat(labels), colors: labels.map((_, k) => this.colours[k % this.colours.length]), series,
        customBars: this.banded, fillAlpha: 0.22, strokeWidth: 1.3, logscale: spec.log, connectSeparatedPoints: true,
        gridLineColor: rule, axisLineColor: '#8a94a0', highlightCircleSize: 0, dateWindow: view.slice(), legend: 'never',
        axes: {x: {ticker: timeTicks, axisLabelFormatter: t => timeLabel(t), valueFormatter: t => timeText(t)},
          y: spec.names ? {axisLabelWidth: 110, ticker: () => spec.names.map((name, k) => ({v: k, label: name}))} : {axisLabelWidth: 58, axisLabelFormatter: v => String(Number(v.toPrecision(6)))}},
        valueRange: spec.names ? [-0.5, spec.names.length - 0.5] : null,
        underlayCallback: (context, area, graph) => chart.underlay(context, area, graph),
        interactionModel: interaction(this), animatedZooms: false, rightGap: 8, xLabelHeight: 0, yRangePad: 6,
      });
      if (spec.names) this.yWindow = [-0.5, spec.names.length - 0.5];
      this.box.append(this.line);
      this.point();
    }

    underlay(context, area, graph) {
      const fill = (intervals, colour) => {
        context.fillStyle = colour;
        for (const [start, end] of intervals) {
          const left = Math.max(area.x, graph.toDomXCoord(start)), right = Math.min(area.x + area.w, graph.toDomXCoord(end));
          if (right > left) context.fillRect(left, area.y, right - left, area.h);
        }
      };
      fill(page.rest, dark ? 'rgba(120,170,220,.16)' : 'rgba(60,110,160,.10)');
      fill(page.outages, dark ? 'rgba(255,120,100,.18)' : 'rgba(210,60,40,.12)');
      context.strokeStyle = '#8a94a0';
      context.setLineDash([5, 4]);
      for (const level of this.spec.levels || []) {
        const y = graph.toDomYCoord(level);
        if (!(y > area.y && y < area.y + area.h)) continue;
        context.beginPath();
        context.moveTo(area.x, y);
        context.lineTo(area.x + area.w, y);
        context.stroke();
      }
      context.setLineDash([]);
    }

    // The cursor, and the values there.
    point() {
      if (!this.graph || !this.visible) return;
      const shown = cursor !== null && cursor >= view[0] && cursor <= view[1];
      this.line.hidden = !shown;
      if (shown) {
        const area = this.graph.getArea();
        this.line.style.left = this.graph.toDomXCoord(cursor) + 'px';
        this.line.style.top = area.y + 'px';
        this.line.style.height = area.h + 'px';
      }
      this.legend.textContent = '';
      this.spec.curves.forEach((c, k) => {
        const part = document.createElement('span');
        const colour = document.createElement('i');
        colour.style.background = c.label === 'gate' ? '#8a94a0' : this.colours[k % this.colours.length];
        const text = this.spec.curves.length > 1 || !shown ? c.label + ' ' : '';
        part.append(colour, text + (shown ? this.valueAt(k, cursor) : ''));
        this.legend.append(part);
      });
      if (shown) this.legend.append(`at ${timeText(cursor)}${clock === 'utc' ? ' UTC' : ' s'}`);
    }
    valueAt(k, t) {
      if (this.spec.names) return '';
      const {time, value, sigma, low, high} = this.curve(k);
      if (!time.length) return '–';
      const i = nearest(time, t);
      if (low) return `${valueText(value[i], NaN, this.spec.unit)} (${Number(low[i].toPrecision(4))} to ${Number(high[i].toPrecision(4))})`;
      return valueText(value[i], sigma ? sigma[i] : NaN, this.spec.unit);
    }

    drawn() {
      if (!this.graph || this.stale) this.unfold();
      const s = this.series[0] || {t: [], value: [], low: [], high: []};
      const plain = values => Array.from(values, v => Number.isFinite(v) ? v : null);
      return {t: Array.from(s.t), value: plain(s.value), low: plain(s.low), high: plain(s.high)};
    }
    unfold() {
      for (let e = this.place.parentElement; e; e = e.parentElement) if (e.tagName === 'DETAILS') e.open = true;
      if (this.ready && (!this.graph || this.stale)) this.draw();
    }
    async show(start, end) {
      await this.load();
      this.unfold();
      setView(start, end);
      if (this.stale) this.draw();
    }

    saveNumbers() {
      const name = tableName(this.spec.table), head = ['time_s'], columns = [];
      this.load().then(() => {
        this.spec.curves.forEach((c, k) => {
          const curve = this.curve(k);
          head.push(c.label);
          columns.push(curve.value);
          for (const [kind, column] of [['sigma', curve.sigma], ['least', curve.low], ['most', curve.high]]) {
            if (column) { head.push(`${kind}_${c.label}`); columns.push(column); }
          }
        });
        const time = tables[name] ? tables[name].time : this.curve(0).time;
        const lines = [head.join(',')];
        for (let i = lower(time, view[0]); i < time.length && time[i] <= view[1]; i++) {
          lines.push([time[i].toFixed(6)].concat(columns.map(c => Number.isFinite(c[i]) ? Number(c[i].toPrecision(12)) : '')).join(','));
        }
        save(new Blob([lines.join('\n') + '\n'], {type: 'text/csv'}), this.fileName('csv'));
      });
    }
    fileName(end) { return this.spec.name.replace(/[^a-z0-9]+/gi, '_').replace(/^_|_$/g, '') + '.' + end; }
    savePicture() {
      if (!this.graph) return;
      const scale = 2, box = this.box.getBoundingClientRect(), top = 26, canvas = document.createElement('canvas');
      canvas.width = box.width * scale;
      canvas.height = (box.height + top) * scale;
      const context = canvas.getContext('2d');
      context.scale(scale, scale);
      context.fillStyle = ground;
      context.fillRect(0, 0, box.width, box.height + top);
      context.fillStyle = ink;
      context.font = 'bold 13px sans-serif';
      context.fillText(this.spec.title + (this.spec.unit ? ` [${this.spec.unit}]` : ''), 8, 17);
      for (const layer of this.box.querySelectorAll('canvas')) {
        const at = layer.getBoundingClientRect();
        context.drawImage(layer, at.left - box.left, at.top - box.top + top, at.width, at.height);
      }
      context.font = '11px sans-serif';
      context.textBaseline = 'middle';
      for (const label of this.box.querySelectorAll('.dygraph-axis-label')) {
        const at = label.getBoundingClientRect(), right = label.classList.contains('dygraph-axis-label-y');
        context.textAlign = right ? 'right' : 'center';
        context.fillText(label.textContent, right ? at.right - box.left : (at.left + at.right) / 2 - box.left, (at.top + at.bottom) / 2 - box.top + top);
      }
      canvas.toBlob(blob => save(blob, this.fileName('png')));
    }
  }

  function save(blob, name) {
    const link = document.createElement('a');
    link.href = URL.createObjectURL(blob);
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  function timeTicks(a, b, pixels, options, graph) {
    const from = origin();
    return Dygraph.numericTicks(a - from, b - from, pixels, options, graph, null).map(tick => {
      const at = tick.v + from;
      return tick.label === undefined ? {...tick, v: at} : {v: at, label: timeLabel(at)};
    });
  }
  const timeLabel = t => clock === 'utc' ? timeText(t, view[1] - view[0] < 20 ? 3 : 0) : String(Number((t - origin()).toFixed(4)));

  // Drag: a box, or along one axis. Wheel with Ctrl, or after a click: zoom about the pointer. Shift and drag: pan. Two fingers: zoom.
  function interaction(chart) {
    const nearlyFlat = 12;
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
      if (dx >= nearlyFlat || dx > dy) setView(...times); else drawVisible();
    };
    const pinch = () => {
      const [a, b] = [...fingers.values()];
      const g = chart.graph, left = Math.min(a.x, b.x), right = Math.max(a.x, b.x), area = g.getArea();
      if (right - left < 10) return;
      // The times that were under the fingers stay under them.
      const t0 = Math.min(a.t, b.t), t1 = Math.max(a.t, b.t), scale = (t1 - t0) / (right - left), start = t0 - (left - area.x) * scale;
      setView(start, start + area.w * scale);
    };
    const model = {
      pointerdown(event) {
        const at = place(event);
        chart.box.setPointerCapture(event.pointerId);
        if (event.pointerType === 'touch') fingers.set(event.pointerId, {x: at[0], t: chart.graph.toDataXCoord(at[0])});
        from = {at, view: view.slice(), pan: event.shiftKey || event.pointerType === 'touch'};
        if (from.pan) return;
        box = document.createElement('div');
        box.className = 'zoom-box';
        chart.box.append(box);
      },
      pointermove(event) {
        const at = place(event);
        if (!from) { setCursor(chart.graph.toDataXCoord(at[0])); return; }
        if (fingers.has(event.pointerId)) fingers.get(event.pointerId).x = at[0];
        if (fingers.size === 2) return pinch();
        if (from.pan) {
          const area = chart.graph.getArea(), shift = (from.at[0] - at[0]) * (from.view[1] - from.view[0]) / area.w;
          if (event.pointerType === 'touch' && fingers.size === 1 && Math.abs(from.at[0] - at[0]) < 4) setCursor(chart.graph.toDataXCoord(at[0]));
          else setView(from.view[0] + shift, from.view[1] + shift);
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
        setView(t - (t - view[0]) * factor, t + (view[1] - t) * factor);
      },
      dblclick() { reset(); },
    };
    // Not through the library, whose listeners are of the mouse.
    for (const [name, act] of Object.entries(model)) chart.box.addEventListener(name, act, {passive: false});
    return {};
  }

  function reset() {
    for (const chart of charts) chart.yWindow = chart.spec.names ? [-0.5, chart.spec.names.length - 0.5] : null;
    setView(...whole);
  }

  // ---- The strip of outcomes: a row for each source, a colour for each outcome.

  const measured = [];  // of every receiver, all rows: {time, used, source, outcome, north, east}
  function strip(spec) {
    spec.names = page.sources;
    spec.colours = outcomeColour;
    spec.curves = outcomes.map((label, k) => ({label, value: 'outcome_' + k}));
    const all = [];
    page.sources.forEach((name, k) => {
      const table = tables['source_' + k];
      if (!table) return;
      const time = table.time, outcome = table.column('outcome');
      for (let i = 0; i < table.rows; i++) all.push([time[i], k, outcome[i]]);
    });
    all.sort((a, b) => a[0] - b[0]);
    const table = {rows: all.length, ready: true, load: () => Promise.resolve(), columns: new Map(), has: name => name === 'outcome',
      column(name) { return this.columns.get(name); }, get time() { return this.columns.get('time_s'); }};
    table.columns.set('time_s', Float64Array.from(all, r => r[0]));
    table.columns.set('outcome', Float64Array.from(all, r => r[2]));
    outcomes.forEach((_, k) => table.columns.set('outcome_' + k, Float64Array.from(all, r => r[2] === k ? r[1] : NaN)));
    tables[spec.table] = table;
  }

  // ---- Histograms of residuals in sigmas, beside their chart.

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

  // ---- The plan.

  function ramp(u) {  // viridis, by a few of its colours
    const stops = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
    const at = Math.min(0.9999, Math.max(0, u)) * (stops.length - 1), k = Math.floor(at), f = at - k;
    return `rgb(${stops[k].map((c, i) => Math.round(c + f * (stops[k + 1][i] - c))).join()})`;
  }

  function collectFixes() {
    measured.length = 0;
    const track = tables[which];
    page.sources.forEach((name, k) => {
      const table = tables['source_' + k];
      if (!table || !name.startsWith('gnss')) return;
      const time = table.time, outcome = table.column('outcome'), placed = table.has('north_m');
      const north = placed && table.column('north_m'), east = placed && table.column('east_m');
      for (let i = 0; i < table.rows; i++) {
        const own = placed && Number.isFinite(north[i]), j = own ? 0 : Math.min(track.rows - 1, nearest(track.time, time[i]));
        measured.push({time: Math.round(1e6 * time[i]) / 1e6, used: outcome[i] === 0 || outcome[i] === 2, source: name, outcome: outcome[i], velocity: !placed,
          north: own ? north[i] : track.column('north_m')[j], east: own ? east[i] : track.column('east_m')[j]});
      }
    });
    measured.sort((a, b) => a.time - b.time);
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
      if (kind === 'time') return {values: track.time.map(t => t - page.start), unit: 's'};
      if (kind === 'height') return {values: track.column('height_m'), unit: 'm'};
      if (kind === 'sigma') return {values: valuesOf(which, 'hypot:sigma_north_m,sigma_east_m', 0), unit: 'm'};
      if (kind === 'quality') return {values: recentShare(track.time), unit: 'share of fixes used'};
      const speed = valuesOf(which, 'hypot:velocity_north_m_s,velocity_east_m_s,velocity_down_m_s', 0);
      if (!speed.some(Number.isFinite)) return {values: track.time.map(t => t - page.start), unit: 's'};
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
      const {values, unit} = colouring(), track = tables[which], time = track.time, {x: tx, y: ty} = points.track;
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
          if (!outside(x, y)) mark(context, x, y, fix);
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
        const now = time[i] < view[0] || time[i] > view[1] ? (dark ? '#4a535d' : '#c8ced4') : ramp((values[i] - low) / (high - low || 1));
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
          for (let i = lower(time, start); i < time.length && time[i] <= end; i++) context.lineTo(X(tx[i]), Y(ty[i]));
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
      legend(low, high, unit);
      place();
    }
    function mark(context, x, y, fix) {
      const colour = outcomeColour[fix.outcome];
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
    function legend(low, high, unit) {
      const there = new Set(measured.map(fix => fix.outcome)), signs = ['·', '×', '○', '△', '□'], out = byId('scale');
      out.textContent = '';
      const bar = document.createElement('span');
      bar.className = 'ramp';
      bar.style.background = `linear-gradient(90deg, ${[0, 0.25, 0.5, 0.75, 1].map(ramp).join()})`;
      const text = v => v.toFixed(Math.max(0, Math.min(6, 2 - Math.floor(Math.log10(high - low || 1)))));
      out.append(text(low) + ' ', bar, ` ${text(high)} ${unit}`);
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
      const shown = cursor !== null && map;
      marker.hidden = !shown;
      if (!shown) return;
      const track = tables[which], i = nearest(track.time, cursor), zoom = map.getZoomScale(map.getZoom(), 0), corner = map.getPixelBounds().min;
      marker.style.left = points.track.x[i] * zoom - corner.x + 'px';
      marker.style.top = points.track.y[i] * zoom - corner.y + 'px';
    }
    // The time of the place next to the pointer.
    function findTime(event) {
      const zoom = map.getZoomScale(map.getZoom(), 0), corner = map.getPixelBounds().min, p = event.containerPoint, {x, y} = points.track;
      const time = tables[which].time;
      let best = -1, least = 30 * 30;
      for (let i = 0; i < x.length; i++) {
        if (time[i] < view[0] || time[i] > view[1]) continue;
        const dx = x[i] * zoom - corner.x - p.x, dy = y[i] * zoom - corner.y - p.y, square = dx * dx + dy * dy;
        if (square < least) { least = square; best = i; }
      }
      if (best >= 0) setCursor(time[best]);
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
    open('');
    listeners.push(() => { if (viewDrawn !== view) { viewDrawn = view; layer.draw(); } else place(); });
    let viewDrawn = view;
    for (const id of ['colour', 'fixes-shown', 'ellipses-shown']) byId(id).addEventListener('change', () => layer.draw());
    byId('tiles-on').addEventListener('click', () => open(byId('tiles').value.trim()));
    new ResizeObserver(() => map.invalidateSize({animate: false})).observe(box);
    plan = {changed() { collectFixes(); project(); layer.draw(); }};
  }

  // ---- The page.

  const handles = {};
  const seen = new IntersectionObserver(entries => {
    for (const entry of entries) {
      const chart = charts.find(c => c.place === entry.target);
      chart.visible = entry.isIntersecting;
      if (chart.visible && chart.stale) chart.draw();
      else if (chart.visible) chart.point();
    }
  }, {rootMargin: '200px'});

  function addCharts(specs) {
    for (const spec of specs) {
      const place = [...document.querySelectorAll('.place')].find(p => p.dataset.chart === spec.name);
      if (!place) continue;
      if (spec.name === 'outcome') strip(spec);
      const chart = new Chart(spec, place);
      charts.push(chart);
      handles[spec.name] = {show: (a, b) => chart.show(a, b), drawn: () => chart.drawn(),
        window: () => ({time: view.slice(), value: chart.graph ? chart.graph.yAxisRange() : null})};
      seen.observe(place);
    }
  }

  const frame = () => new Promise(next => requestAnimationFrame(() => setTimeout(next)));
  async function start() {
    const early = page.charts.filter(spec => spec.name !== 'outcome');
    if (tables[which]) await tables[which].load();
    addCharts(early);
    for (const chart of charts.slice(0, 2)) { await chart.load(); chart.visible = true; chart.draw(); }
    byId('tools').hidden = false;
    await frame();
    for (const name of Object.keys(tables).filter(name => name.startsWith('source_'))) await tables[name].load();
    makePlan();
    window.piste = {charts: handles, fixes: {drawn: () => measured.map(({time, used, source}) => ({time, used, source}))}};
    await frame();
    addCharts(page.charts.filter(spec => spec.name === 'outcome'));
    for (const name of Object.keys(tables)) { await tables[name].load(); await frame(); }
    for (const chart of charts) if (chart.spec.name.startsWith('ratio_')) histogram(chart);
  }

  function choose(name) {
    which = name;
    for (const chart of charts) chart.stale = true;
    Promise.all([tables[name].load(), tables['biases_' + name]?.load()]).then(() => { drawVisible(); if (plan) plan.changed(); });
  }
  const choice = byId('which');
  if (choice) {
    if (!tables.smoothed || !tables.filtered) choice.hidden = true;
    choice.addEventListener('change', event => choose(event.target.value));
  }
  const clocks = byId('clock');
  if (clocks) {
    if (page.week !== null) {
      clocks.add(new Option('UTC', 'utc'));
      byId('subtitle').prepend(utcOf(page.start).toISOString().slice(0, 19).replace('T', ' ') + ' UTC · ');
    }
    clocks.addEventListener('change', () => { clock = clocks.value; setView(...view); });
    byId('reset').addEventListener('click', reset);
  }
  window.addEventListener('resize', () => setView(...view));

  if (typeof DecompressionStream === 'undefined') {
    notice('This browser is too old for plan and charts (it has no DecompressionStream); a version of 2023 or later shows them. The tables are complete.');
  } else {
    start().catch(error => notice(`Plan and charts cannot be shown: ${error.message}`));
  }
})();
