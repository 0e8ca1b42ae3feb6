// Which rows of a window are drawn.

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
