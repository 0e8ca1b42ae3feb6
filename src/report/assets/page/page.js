// Puts the page together: charts as they come into view, choices, and `window.piste`, by which a program drives it.

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
    if (strips[spec.name]) strip(spec);
    const chart = new Chart(spec, place);
    charts.push(chart);
    chart.axis.charts.push(chart);
    handles[spec.name] = {show: (a, b) => chart.show(a, b), drawn: () => chart.drawn(), curves: () => chart.curvesDrawn(),
      window: () => ({time: chart.axis.view.map(x => chart.axis.value(x)), value: chart.graph ? chart.graph.yAxisRange() : null})};
    seen.observe(place);
  }
}

const frame = () => new Promise(next => requestAnimationFrame(() => setTimeout(next)));
async function start() {
  const early = page.charts.filter(spec => !strips[spec.name]);
  if (tables[which]) await tables[which].load();
  addCharts(early);
  for (const chart of charts.slice(0, 2)) { await chart.load(); chart.visible = true; chart.draw(); }
  byId('tools').hidden = false;
  await frame();
  for (const name of Object.keys(tables).filter(name => name.startsWith('source_'))) await tables[name].load();
  makePlan();
  window.piste = {charts: handles, fixes: {drawn: () => measured.map(({time, used, source}) => ({time, used, source}))}};
  await frame();
  for (const spec of page.places) await showPlaces(spec);
  addCharts(page.charts.filter(spec => strips[spec.name]));
  for (const name of Object.keys(tables)) { await tables[name].load(); await frame(); }
  for (const chart of charts) if (chart.spec.name.startsWith('ratio_')) histogram(chart);
}

function choose(name) {
  which = name;
  for (const chart of time.charts) chart.stale = true;
  Promise.all([tables[name].load(), tables['biases_' + name]?.load()]).then(() => { time.drawVisible(); if (plan) plan.changed(); });
}
const choice = byId('which');
if (choice) {
  if (!tables.smoothed || !tables.filtered) choice.hidden = true;
  choice.addEventListener('change', event => choose(event.target.value));
}
const clocks = byId('clock');
if (clocks) {
  if (page.utc !== null) clocks.add(new Option('UTC', 'utc'));
  clocks.addEventListener('change', () => { time.clock = clocks.value; time.show(...time.view); });
}
if (byId('reset')) byId('reset').addEventListener('click', () => Object.values(axes).forEach(axis => axis.reset()));
window.addEventListener('resize', () => Object.values(axes).forEach(axis => axis.show(...axis.view)));

if (typeof DecompressionStream === 'undefined') {
  notice('This browser is too old for plan and charts (it has no DecompressionStream); a version of 2023 or later shows them. The tables are complete.');
} else {
  start().catch(error => notice(`Plan and charts cannot be shown: ${error.message}`));
}
