// Draws the charts of the page from `report`: {solutions: {name: [chart]}, innovations: [chart], rest, outages}.
'use strict';
(function () {
  const dark = matchMedia('(prefers-color-scheme: dark)').matches;
  const palette = dark ? ['#5aaeff', '#ff9350', '#3fc79a', '#e58cc4'] : ['#0067b8', '#c04f00', '#00805c', '#a8417f'];
  const outcome = {used: palette[0], rejected: dark ? '#ff6b6b' : '#d1242f', readmitted: palette[2], disputed: palette[3],
    gate: '#8a94a0'};
  const graphs = [];

  // Rows for dygraphs: [time, value …] or [time, [value, sigma] …].
  function rows(chart) {
    const banded = chart.curves.some(c => c.sigma);
    return chart.time.map((t, i) =>
      [t].concat(chart.curves.map(c => banded ? (c.value[i] === null ? [null, null] : [c.value[i], c.sigma ? c.sigma[i] : 0]) : c.value[i])));
  }

  function shade(context, area, graph) {
    const fill = (intervals, colour) => {
      context.fillStyle = colour;
      for (const [start, end] of intervals) {
        const left = Math.max(area.x, graph.toDomXCoord(start));
        const right = Math.min(area.x + area.w, graph.toDomXCoord(end));
        if (right > left) context.fillRect(left, area.y, right - left, area.h);
      }
    };
    fill(report.rest, dark ? 'rgba(120,170,220,.16)' : 'rgba(60,110,160,.10)');
    fill(report.outages, dark ? 'rgba(255,120,100,.18)' : 'rgba(210,60,40,.12)');
  }

  // What is zoomed in one chart is zoomed in all.
  function follow(start, end) {
    for (const graph of graphs) graph.updateOptions({dateWindow: [start, end]});
  }

  function add(parent, chart) {
    const heading = document.createElement('h3');
    heading.append(chart.title);
    const legend = document.createElement('div');
    legend.className = 'legend soft';
    const box = document.createElement('div');
    box.className = 'chart';
    box.setAttribute('role', 'img');
    box.setAttribute('aria-label', `${chart.title}${chart.unit ? ' in ' + chart.unit : ''} over time: ` +
      chart.curves.map(c => c.label).join(', '));
    parent.append(heading, legend, box);
    const colours = chart.curves.map((c, i) => outcome[c.label] || palette[i % palette.length]);
    const series = {};
    for (const c of chart.curves) {
      if (chart.points && c.label !== 'gate') series[c.label] = {drawPoints: true, strokeWidth: 0, pointSize: 2};
      if (c.label === 'gate') series[c.label] = {strokeWidth: 1.5, strokePattern: [6, 4], connectSeparatedPoints: true};
    }
    const graph = new Dygraph(box, rows(chart), {
      labels: ['time'].concat(chart.curves.map(c => c.label)), labelsDiv: legend, legend: 'always', colors: colours, series,
      errorBars: chart.curves.some(c => c.sigma), sigma: 1, fillAlpha: 0.2, strokeWidth: 1.4, logscale: chart.log,
      gridLineColor: dark ? '#3a424b' : '#dde2e7', axisLineColor: '#8a94a0', highlightCircleSize: 3,
      xlabel: 'time [s]', ylabel: chart.unit ? `[${chart.unit}]` : '', xLabelHeight: 16, yLabelWidth: 16,
      axes: {y: {axisLabelWidth: 64}}, xRangePad: 4, digitsAfterDecimal: 6, maxNumberWidth: 9,
      underlayCallback: shade, zoomCallback: follow, animatedZooms: false,
    });
    graphs.push(graph);
    return graph;
  }

  const names = Object.keys(report.solutions);
  const place = document.getElementById('solution-charts');
  // By title, as a solution has no chart where it has nothing to show.
  const shown = {};
  for (const chart of report.solutions[names[names.length - 1]]) shown[chart.title] = add(place, chart);
  for (const input of document.querySelectorAll('.switch input')) {
    input.addEventListener('change', () => {
      for (const chart of report.solutions[input.value]) {
        if (shown[chart.title]) shown[chart.title].updateOptions({file: rows(chart)});
      }
    });
  }
  for (const chart of report.innovations) add(document.getElementById('innovation-charts'), chart);
})();
