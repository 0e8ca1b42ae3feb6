// One chart: its window of rows, its cursor, and what it has drawn.

class Chart {
  constructor(spec, place) {
    Object.assign(this, {spec, place, axis: axes[spec.axis || 'time'], stale: true, visible: false, series: []});
    this.yWindow = this.wholeValues();
    const heading = document.createElement('div');
    heading.className = 'chart-head';
    const title = document.createElement('b');
    title.textContent = spec.title + (spec.unit ? ` [${spec.unit}]` : '');
    this.legend = document.createElement('span');
    this.legend.className = 'legend';
    const tools = document.createElement('span');
    tools.className = 'chart-tools';
    for (const [text, act] of [['PNG', savePicture], ['CSV', saveNumbers]]) {
      const button = document.createElement('button');
      button.type = 'button';
      button.textContent = text;
      button.title = `${spec.title} as ${text}`;
      button.addEventListener('click', () => act(this));
      tools.append(button);
    }
    if (this.axis !== time) {
      const over = document.createElement('span');
      over.className = 'soft';
      over.textContent = `over ${this.axis.column}`;
      title.append(' ', over);
    }
    heading.append(title, this.legend, tools);
    this.box = document.createElement('div');
    this.box.className = 'chart';
    this.box.setAttribute('role', 'img');
    this.box.setAttribute('aria-label', `${spec.title}${spec.unit ? ' in ' + spec.unit : ''} over ${this.axis.label}`);
    this.line = document.createElement('div');
    this.line.className = 'cursor';
    place.append(heading, this.box);
  }
  // The values that are shown at first; null: as the curves need.
  wholeValues() { return this.spec.names ? [-0.5, this.spec.names.length - 0.5] : this.spec.limits || null; }
  colour(k) {
    const {label, colour} = this.spec.curves[k], all = this.spec.colours || palette;
    if (label === 'gate') return '#8a94a0';
    return colour === -1 ? ink : all[(colour ?? k) % all.length];
  }
  dotted(k) { return this.spec.points ? this.spec.curves[k].label !== 'gate' : this.spec.curves[k].stroke === 'dots'; }
  tableOf(k) { return tableName(this.spec.curves[k].table || this.spec.table); }
  tables() {
    const names = [tableName(this.spec.table)];
    for (const c of this.spec.curves) {
      if (c.table) names.push(c.table);
      for (const e of [c.value, c.sigma]) {
        if (e && e.startsWith('change:')) names.push('filtered', 'smoothed');
        if (e && tables[e.split(':')[0]]) names.push(e.split(':')[0]);
      }
    }
    return [...new Set(names)].filter(name => tables[name]).map(name => tables[name]);
  }
  load() { return Promise.all(this.tables().map(table => table.load())); }
  get ready() { return this.tables().every(table => table.ready); }

  // The columns of a curve, whole.
  curve(k) {
    const c = this.spec.curves[k], name = this.tableOf(k), turn = this.spec.turn;
    const value = valuesOf(name, c.value, turn), sigma = c.sigma ? valuesOf(name, c.sigma, 0) : null;
    return {x: tables[name].x, value, sigma, low: c.low ? valuesOf(name, c.low, 0) : null, high: c.high ? valuesOf(name, c.high, 0) : null};
  }

  // What the library is given of one curve: {t, value, low, high}, NaN where the line breaks.
  pick(k, bins) {
    const {x, value, sigma, low, high} = this.curve(k), turn = this.spec.turn, wraps = turn && !this.spec.name.includes('_of_');
    const refused = this.refused();
    const rows = this.dotted(k) || this.spec.points ? rowsToDot(x, this.axis.view, 8000, i => refused[i]) : rowsToDraw(x, value, this.axis.view, bins);
    const out = {t: [], value: [], low: [], high: []};
    const add = (t, v, l, h) => { out.t.push(t); out.value.push(v); out.low.push(l); out.high.push(h); };
    let before = NaN;
    for (const i of rows) {
      const v = value[i];
      if (wraps && Math.abs(v - before) > turn / 2) add(x[i], NaN, NaN, NaN);
      before = v;
      if (low) add(x[i], v, low[i], high[i]);
      else add(x[i], v, sigma ? v - sigma[i] : v, sigma ? v + sigma[i] : v);
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
    if (!rows.length) rows.push([this.axis.view[0]].concat(Array(count).fill(this.banded ? [null, null, null] : null)));
    return rows;
  }

  draw() {
    if (!this.ready) { this.load().then(() => { if (this.stale) this.draw(); }); return; }
    this.stale = false;
    this.banded = !this.spec.points && this.spec.curves.some(c => c.sigma || c.low);
    const data = this.joined();
    if (!this.graph) return this.create(data);
    this.graph.updateOptions({file: data, dateWindow: this.axis.view.slice(), valueRange: this.yWindow});
    this.point();
  }

  create(data) {
    const spec = this.spec, series = {};
    const labels = spec.curves.map(c => c.label);
    labels.forEach((label, k) => {
      const own = series[label] = {};
      const stroke = label === 'gate' ? 'dashed' : spec.curves[k].stroke;
      if (this.dotted(k)) Object.assign(own, {drawPoints: true, strokeWidth: 0, pointSize: spec.names && label !== 'used' ? 3.5 : 1.7});
      if (this.dotted(k) && this.banded) own.plotter = whiskers;
      if (stroke === 'none') own.strokeWidth = 0;
      if (stroke === 'dashed' || stroke === 'dotted') Object.assign(own, {strokeWidth: 1.5, strokePattern: stroke === 'dashed' ? [6, 4] : [2, 3]});
    });
    const chart = this, axis = this.axis;
    this.graph = new Dygraph(this.box, data, {
      labels: ['time'].concat(labels), colors: labels.map((_, k) => this.colour(k)), series,
      customBars: this.banded, fillAlpha: 0.22, strokeWidth: 1.3, logscale: spec.log, connectSeparatedPoints: true,
      gridLineColor: rule, axisLineColor: '#8a94a0', highlightCircleSize: 0, dateWindow: axis.view.slice(), legend: 'never',
      axes: {x: {ticker: (...of) => axis.ticks(...of), axisLabelFormatter: x => axis.tickText(x)},
        y: spec.names ? {axisLabelWidth: 110, ticker: () => spec.names.map((name, k) => ({v: k, label: name}))} : {axisLabelWidth: 58, axisLabelFormatter: v => String(Number(v.toPrecision(6)))}},
      valueRange: this.yWindow,
      underlayCallback: (context, area, graph) => chart.underlay(context, area, graph),
      interactionModel: interaction(this), animatedZooms: false, rightGap: 8, xLabelHeight: 0, yRangePad: 6,
    });
    this.box.append(this.line);
    this.point();
  }

  underlay(context, area, graph) {
    for (const {from, to, kind} of this.axis.shades) {
      const left = Math.max(area.x, graph.toDomXCoord(from)), right = Math.min(area.x + area.w, graph.toDomXCoord(to));
      context.fillStyle = shadeColours[kind];
      if (right > left) context.fillRect(left, area.y, right - left, area.h);
    }
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
    const {cursor, view} = this.axis, shown = cursor !== null && cursor >= view[0] && cursor <= view[1];
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
      colour.style.borderColor = this.colour(k);
      colour.className = this.dotted(k) ? 'dots' : c.label === 'gate' ? 'dashed' : c.stroke === 'none' ? 'area' : c.stroke || '';
      const text = this.spec.curves.length > 1 || !shown ? c.label + ' ' : '';
      part.append(colour, text + (shown ? this.valueAt(k, cursor) : ''));
      this.legend.append(part);
    });
    if (shown) this.legend.append(this.axis.cursorText(cursor));
  }
  valueAt(k, t) {
    if (this.spec.names) return '';
    const {x, value, sigma, low, high} = this.curve(k);
    if (!x.length) return '–';
    const i = nearest(x, t);
    const half = low ? (high[i] - low[i]) / 2 : NaN;
    if (low && Math.abs(low[i] + half - value[i]) < 0.02 * half) return valueText(value[i], half, this.spec.unit);  // ± sigma
    if (low) return `${valueText(value[i], NaN, this.spec.unit)} (${Number(low[i].toPrecision(4))} to ${Number(high[i].toPrecision(4))})`;
    return valueText(value[i], sigma ? sigma[i] : NaN, this.spec.unit);
  }

  // Of each curve what the library has been given.
  curvesDrawn() {
    if (!this.graph || this.stale) this.unfold();
    const plain = values => Array.from(values, v => Number.isFinite(v) ? v : null);
    return this.series.map((s, k) => ({label: this.spec.curves[k].label, t: Array.from(s.t, x => this.axis.value(x)), value: plain(s.value), low: plain(s.low), high: plain(s.high)}));
  }
  drawn() {
    const {t, value, low, high} = this.curvesDrawn()[0] || {t: [], value: [], low: [], high: []};
    return {t, value, low, high};
  }
  unfold() {
    for (let e = this.place.parentElement; e; e = e.parentElement) if (e.tagName === 'DETAILS') e.open = true;
    if (this.ready && (!this.graph || this.stale)) this.draw();
  }
  async show(start, end) {
    await this.load();
    this.unfold();
    this.axis.show(this.axis.place(start), this.axis.place(end));
    if (this.stale) this.draw();
  }
}

const shadeColours = {rest: dark ? 'rgba(120,170,220,.16)' : 'rgba(60,110,160,.10)', outage: dark ? 'rgba(255,120,100,.18)' : 'rgba(210,60,40,.12)',
  turn: dark ? 'rgba(230,237,243,.07)' : 'rgba(36,41,47,.06)'};

// Dots with their bars, in place of a line and its band.
function whiskers({points, color, drawingContext: context, plotArea: area}) {
  context.save();
  context.strokeStyle = context.fillStyle = color;
  context.lineWidth = 1.2;
  for (const p of points) {
    if (!Number.isFinite(p.canvasy)) continue;
    context.beginPath();
    context.arc(p.canvasx, p.canvasy, 2.2, 0, 2 * Math.PI);
    context.fill();
    if (!(Number.isFinite(p.y_top) && Number.isFinite(p.y_bottom)) || p.y_top === p.y_bottom) continue;
    context.beginPath();
    context.moveTo(p.canvasx, area.y + area.h * p.y_top);
    context.lineTo(p.canvasx, area.y + area.h * p.y_bottom);
    context.stroke();
  }
  context.restore();
}
