// What became of each measurement: the strips of the sources, and the fixes of the plan.

const measured = [];  // of every receiver, all rows: {time, used, source, outcome, north, east}

// A row for each source, a colour for each outcome.
function strip(spec) {
  spec.names = page.sources;
  spec.colours = outcomeColour;
  spec.curves = outcomes.map((label, k) => ({label, value: 'outcome_' + k}));
  const all = [];
  page.sources.forEach((name, k) => {
    const table = tables['source_' + k];
    if (!table) return;
    const at = table.x, outcome = table.column('outcome');
    for (let i = 0; i < table.rows; i++) all.push([at[i], k, outcome[i]]);
  });
  all.sort((a, b) => a[0] - b[0]);
  const table = {rows: all.length, ready: true, load: () => Promise.resolve(), columns: new Map(), has: name => name === 'outcome',
    column(name) { return this.columns.get(name); }, get x() { return this.columns.get('time_s'); }};
  table.columns.set('time_s', Float64Array.from(all, r => r[0]));
  table.columns.set('outcome', Float64Array.from(all, r => r[2]));
  outcomes.forEach((_, k) => table.columns.set('outcome_' + k, Float64Array.from(all, r => r[2] === k ? r[1] : NaN)));
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
    for (let i = 0; i < table.rows; i++) {
      const own = placed && Number.isFinite(north[i]), j = own ? 0 : Math.min(track.rows - 1, nearest(track.x, at[i]));
      measured.push({time: Math.round(1e6 * at[i]) / 1e6, used: outcome[i] === 0 || outcome[i] === 2, source: name, outcome: outcome[i], velocity: !placed,
        north: own ? north[i] : track.column('north_m')[j], east: own ? east[i] : track.column('east_m')[j]});
    }
  });
  measured.sort((a, b) => a.time - b.time);
}

