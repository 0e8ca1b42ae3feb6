// What became of each measurement: the strips of the sources, and the fixes of the plan.

const measured = [];  // of every receiver, all rows: {time, used, source, outcome, quality, satellites, north, east}

// Strips: a row for each source that has the column, a colour for each of its kinds.
const strips = {outcome: {column: 'outcome', kinds: outcomes, colours: outcomeColour},
  quality: {column: 'quality', kinds: qualities, colours: qualityColour}};
function strip(spec) {
  const {column, kinds, colours} = strips[spec.name], all = [], there = new Set();
  spec.names = [];
  page.sources.forEach((name, k) => {
    const table = tables['source_' + k];
    if (!table || !table.has(column)) return;
    const at = table.x, values = table.column(column);
    for (let i = 0; i < table.rows; i++) {
      if (Number.isFinite(values[i])) { all.push([at[i], spec.names.length, values[i]]); there.add(values[i]); }
    }
    spec.names.push(name);
  });
  all.sort((a, b) => a[0] - b[0]);
  const shown = kinds.map((label, k) => k).filter(k => spec.name === 'outcome' || there.has(k));
  spec.curves = shown.map(k => ({label: kinds[k], value: 'kind_' + k}));
  spec.colours = shown.map(k => colours[k]);
  const table = {rows: all.length, ready: true, load: () => Promise.resolve(), columns: new Map(), has: name => name === column,
    column(name) { return this.columns.get(name); }, get x() { return this.columns.get('time_s'); }};
  table.columns.set('time_s', Float64Array.from(all, r => r[0]));
  table.columns.set(column, Float64Array.from(all, r => r[2]));
  kinds.forEach((_, k) => table.columns.set('kind_' + k, Float64Array.from(all, r => r[2] === k ? r[1] : NaN)));
  tables[spec.table] = table;
}

function collectFixes() {
  measured.length = 0;
  const track = tables[which];
  page.sources.forEach((name, k) => {
    const table = tables['source_' + k];
    if (!table || !name.startsWith('gnss')) return;
    const at = table.x, outcome = table.column('outcome'), placed = table.has('north_m');
    const north = placed && table.column('north_m'), east = placed && table.column('east_m');
    const of = name => table.has(name) ? table.column(name) : [], quality = of('quality'), satellites = of('satellites');
    for (let i = 0; i < table.rows; i++) {
      const own = placed && Number.isFinite(north[i]), j = own ? 0 : Math.min(track.rows - 1, nearest(track.x, at[i]));
      measured.push({time: Math.round(1e6 * at[i]) / 1e6, used: outcome[i] === 0 || outcome[i] === 2, source: name, outcome: outcome[i], velocity: !placed, quality: quality[i] ?? NaN, satellites: satellites[i] ?? NaN,
        north: own ? north[i] : track.column('north_m')[j], east: own ? east[i] : track.column('east_m')[j]});
    }
  });
  measured.sort((a, b) => a.time - b.time);
}

