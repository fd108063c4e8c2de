// SPDX-License-Identifier: BSD-2-Clause
// Computes the positions of places and of the lines between them. No line crosses a place that it does not join.

export const kWidth = 190, kHeight = 92;
const kGap = 110, kRow = 26, kCrowd = 40; // between columns, between places of a column, extra width for many lines
const kAbove = 34, kLane = 18; // in a tree: room for labels above places, distance of lines beside it

/**
 * Columns from left to right, all places of the same width. Joined places are in neighbouring columns, so lines only
 * need the gaps between columns.
 */
export function inColumns(columns, edges, own) {
  const at = new Map();
  const most = Math.max(1, ...columns.map((c) => c.length));
  const column = new Map(columns.flatMap((places, i) => places.map((p) => [p.name, i])));
  const crowd = columns.map(() => 0); // number of lines to the right of each column
  for (const { a, b } of edges) crowd[Math.min(column.get(a), column.get(b))] += 1;
  let x = 0;
  columns.forEach((places, i) => {
    places.forEach((p, j) => at.set(p.name, { x, y: (j + (most - places.length) / 2) * (kHeight + kRow), width: own }));
    if (i + 1 < columns.length) x += own + kGap + Math.min(6, Math.max(0, crowd[i] - 2)) * kCrowd;
  });
  const line = (a, b) => {
    const [p, q] = [at.get(a), at.get(b)];
    const right = q.x > p.x;
    return [[right ? p.x + own : p.x, p.y + kHeight / 2], [right ? q.x : q.x + own, q.y + kHeight / 2]];
  };
  // Lines cross in the middle of a gap, so a label that has no room there moves towards an end.
  const labels = (a, b) => {
    const [[x1, y1], [x2, y2]] = line(a, b);
    return [.5, .4, .6, .3, .7, .25, .75, .45, .55, .35, .65].map((t) => ({ x: x1 + (x2 - x1) * t, y: y1 + (y2 - y1) * t, anchor: "middle" }));
  };
  return { at, line, labels, stacked: true, width: x + own, height: most * (kHeight + kRow) - kRow };
}

/** The places in the order of a tree, each after the place from which it is reached: [place, depth, from]. */
function treeOf(columns) {
  const behind = new Map();
  columns.forEach((column, i) => column.forEach((p) => {
    const from = i === 0 ? null : columns[i - 1].find((q) => q.next.has(p.name)) ?? null;
    behind.set(from, [...(behind.get(from) ?? []), p]);
  }));
  const rows = [];
  const rest = (behind.get(null) ?? []).map((p) => [p, 0, null]).reverse();
  while (rest.length) {
    const [p, depth, from] = rest.pop();
    rows.push([p, depth, from]);
    rest.push(...(behind.get(p) ?? []).map((child) => [child, depth + 1, p]).reverse());
  }
  return rows;
}

/**
 * For a narrow screen: one place in each row, indented below the place from which it is reached. All further lines are
 * drawn in lanes beside the places.
 */
export function inTree(columns, edges, available) {
  const rows = treeOf(columns);
  const from = new Map(rows.map(([p, , q]) => [p.name, q?.name]));
  const row = new Map(rows.map(([p], i) => [p.name, i]));
  const lanes = []; // by lane: the edges in it, as rows from and to
  const beside = new Map();
  for (const { a, b } of edges) {
    if (!row.has(a) || !row.has(b) || from.get(a) === b || from.get(b) === a) continue;
    const [top, bottom] = [row.get(a), row.get(b)].sort((m, n) => m - n);
    let lane = lanes.findIndex((taken) => taken.every(([m, n]) => n < top || m > bottom));
    if (lane < 0) lane = lanes.push([]) - 1;
    lanes[lane].push([top, bottom]);
    beside.set(`${a}\n${b}`, lane);
  }
  const deepest = Math.max(1, ...rows.map(([, depth]) => depth));
  const right = Math.max(kWidth + deepest * 12, Math.min(available - 12, 420) - lanes.length * kLane);
  const indent = Math.min(30, Math.floor((right - kWidth) / deepest));
  const at = new Map(rows.map(([p, depth], i) => [p.name,
    { x: depth * indent, y: i * (kHeight + kAbove), width: right - depth * indent }]));
  const line = (a, b) => {
    const [p, q] = [at.get(a), at.get(b)];
    if (from.get(b) === a) {
      const x = p.x + indent / 2;
      return [[x, p.y + kHeight], [x, q.y + kHeight / 2], [q.x, q.y + kHeight / 2]];
    }
    if (from.get(a) === b) return line(b, a).reverse();
    const lane = beside.get(`${a}\n${b}`) ?? beside.get(`${b}\n${a}`);
    const x = right + kLane * (lane + .75);
    const y = (place) => place.y + kHeight / 2 + (lane % 5 - 2) * 12;
    return [[right, y(p)], [x, y(p)], [x, y(q)], [right, y(q)]];
  };
  const labels = (a, b) => {
    if (from.get(b) === a || from.get(a) === b) {
      const q = at.get(from.get(b) === a ? b : a);
      return [{ x: q.x, y: q.y - kAbove / 2, anchor: "start" }];
    }
    const [p, q] = [at.get(a), at.get(b)].sort((m, n) => n.y - m.y);
    return [p.y - kAbove / 2, q.y + kHeight + kAbove / 2].map((y) => ({ x: right, y, anchor: "end" }));
  };
  return { at, line, labels, stacked: false, width: right + lanes.length * kLane, height: rows.length * (kHeight + kAbove) - kAbove };
}
