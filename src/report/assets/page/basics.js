// The page's numbers, its colours, and what all other files use.

const page = JSON.parse(document.getElementById('page-data').textContent);
const dark = matchMedia('(prefers-color-scheme: dark)').matches;
const palette = dark ? ['#5aaeff', '#ff9350', '#3fc79a', '#e58cc4', '#d8c04a', '#a99cff', '#8a94a0']
  : ['#0067b8', '#c04f00', '#00805c', '#a8417f', '#8a6d00', '#5b4bc4', '#8a94a0'];
const outcomes = ['used', 'rejected', 'readmitted', 'disputed', 'repeated'];
const outcomeColour = [palette[0], dark ? '#ff6b6b' : '#d1242f', palette[2], palette[3], '#8a94a0'];
// FixQuality of the library.
const qualities = ['unknown', 'single', 'SBAS', 'differential', 'PPP', 'float', 'fixed', 'dead-reckoned'];
const qualityColour = ['#8a94a0', dark ? '#ff6b6b' : '#d1242f', palette[1], palette[4], palette[5], palette[0], palette[2], palette[3]];
const ink = dark ? '#e6edf3' : '#24292f', ground = dark ? '#14181d' : '#ffffff', rule = dark ? '#3a424b' : '#dde2e7';
const byId = id => document.getElementById(id);
const notice = text => { const n = byId('notice'); if (n) { n.textContent = text; n.hidden = false; } };
