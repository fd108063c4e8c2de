// SPDX-License-Identifier: BSD-2-Clause
// Draws the networks hop by hop. A channel is drawn along its route, from its first place to its last one, or to the
// place where it is refused.
import { svg } from "./dom.js";
import { count, many, percent } from "./format.js";
import { inColumns, inTree, kHeight, kWidth } from "./layout.js";
import { lastHop } from "./model.js";

const kEdge = 14; // padding of a box
const kLine = 16; // height of a line of a label
const kWidest = 340; // widest box in a row; longer texts are cut, and the box's title has them

let pen; // canvas context that measures texts
function widthOf(text, font = "13px") {
  if (pen === undefined) pen = document.createElement("canvas").getContext("2d");
  pen.font = `${font} ${getComputedStyle(document.body).fontFamily}`;
  return pen.measureText(text).width;
}
function clipped(text, width, font) {
  if (widthOf(text, font) <= width) return text;
  let [fits, not] = [0, text.length];
  while (fits + 1 < not) {
    const middle = (fits + not) >> 1;
    if (widthOf(`${text.slice(0, middle)}…`, font) <= width) fits = middle;
    else not = middle;
  }
  return `${text.slice(0, fits).replace(/[\uD800-\uDBFF]$/, "")}…`;
}
const points = (corners) => corners.map(([x, y]) => `${x},${y}`).join(" ");

/** The number of lines that cross a box. Each segment is sampled at 25 points. */
function through(box, lines) {
  const hit = ([x1, y1], [x2, y2]) => {
    for (let i = 0; i <= 24; ++i) {
      const [x, y] = [x1 + (x2 - x1) * i / 24, y1 + (y2 - y1) * i / 24];
      if (x > box.left && x < box.right && y > box.top && y < box.bottom) return true;
    }
    return false;
  };
  return lines.filter((corners) => corners.some((corner, i) => i > 0 && hit(corners[i - 1], corner))).length;
}

/** The free position for a label that fewest lines cross; null if there is no room. */
function roomFor(places, width, height, { taken, lines }) {
  let best = null;
  for (const { x, y, anchor } of places) {
    const left = anchor === "middle" ? x - width / 2 : anchor === "end" ? x - width : x;
    const here = { left, top: y - height / 2, right: left + width, bottom: y + height / 2 };
    if (taken.some((t) => here.left < t.right && t.left < here.right && here.top < t.bottom && t.top < here.bottom)) continue;
    here.crossed = through(here, lines);
    if (!best || here.crossed < best.crossed) best = here;
    if (best.crossed <= 1) break; // only its own line
  }
  if (best) taken.push(best);
  return best;
}

/** The text of a place. A graph may identify places by something else than their text. */
const called = (p) => p.label ?? p.name;

function line(e, places, layout) {
  const { a, b, granted, open, refused } = e;
  const carried = granted + open;
  const said = `${called(places.get(a))} and ${called(places.get(b))}: ${many(granted, "delivery", "deliveries")} granted, ${
    open ? `${count(open)} decided at run time, ` : ""}${count(refused)} refused`;
  return svg("g", { class: `edge ${carried ? "" : "idle"}`, role: "img", "aria-label": said }, svg("title", {}, said),
    svg("polyline", { points: points(layout.line(a, b)), "stroke-width": carried ? Math.min(10, 2 + 2 * Math.log10(carried)) : 1.5 }));
}

const kLooks = [["granted", "✓", "good"], ["open", "◌", "warn"], ["refused", "✕", "bad"]];

/** The numbers on a line; null if there are none, or if there is no room. */
function label(e, layout, room) {
  const texts = kLooks.filter(([what]) => e[what]).map(([what, mark, look]) => {
    const text = `${mark} ${count(e[what])}`;
    return { text, look, width: widthOf(text, "600 13px") };
  });
  if (!texts.length) return null;
  const { stacked } = layout;
  const width = stacked ? Math.max(...texts.map((t) => t.width)) : texts.reduce((sum, t) => sum + t.width, 12 * (texts.length - 1));
  const here = roomFor(layout.labels(e.a, e.b), width + 8, (stacked ? texts.length : 1) * kLine + 2, room);
  if (!here) return null; // the line's title has the numbers
  const group = svg("g", { class: "label", "aria-hidden": "true" },
    svg("rect", { x: here.left, y: here.top, width: here.right - here.left, height: here.bottom - here.top, rx: 3 }));
  let [x, y] = [stacked ? (here.left + here.right) / 2 : here.left + 4, here.top + kLine - 3];
  for (const { text, look, width: own } of texts) {
    group.append(svg("text", { x, y, "text-anchor": stacked ? "middle" : "start", class: look }, text));
    if (stacked) y += kLine;
    else x += own + 12;
  }
  return group;
}

const fontOfNote = (p) => p.ill ? "600 13px" : "13px";
/** The width of a box in which nothing is cut. */
const needs = (p) => 2 * kEdge + 1 + Math.max(widthOf(called(p), "600 15px"), widthOf(p.subtitle), widthOf(p.note, fontOfNote(p)));
/** A layout in columns, as wide as the texts need if there is room. */
function asWide(columns, edges, available) {
  const most = Math.min(kWidest, Math.max(kWidth, ...columns.flat().map((p) => Math.ceil(needs(p)))));
  const narrow = inColumns(columns, edges, kWidth);
  const more = Math.floor((available - 12 - narrow.width) / Math.max(1, columns.length));
  return more > 0 && most > kWidth ? inColumns(columns, edges, Math.min(most, kWidth + more)) : narrow;
}

function box(p, at, choose) {
  const { x, y, width } = at.get(p.name);
  const room = width - 2 * kEdge;
  const loaded = p.load !== null && p.load !== undefined;
  const full = `${called(p)}: ${p.subtitle}${p.note ? `. ${p.note}` : ""}${loaded ? `, ${percent(p.load)} reserved` : ""}${
    loaded && p.used ? `, ${percent(p.used.part)} used` : ""}`;
  const node = svg("g", { class: `place ${p.gateway ? "gateway" : ""} ${p.ill ? "ill" : ""}`, tabindex: 0, role: "button",
    "data-place": p.name, transform: `translate(${x} ${y})`, onclick: () => choose(p.name),
    onkeydown: (e) => { if (e.key === "Enter" || e.key === " ") { e.preventDefault(); choose(p.name); } } },
  svg("title", {}, full),
  svg("rect", { width, height: kHeight, rx: p.gateway ? 20 : 6 }),
  svg("text", { x: kEdge, y: 27, class: "name" }, clipped(called(p), room, "600 15px")),
  svg("text", { x: kEdge, y: 47, class: "quiet" }, clipped(p.subtitle, room)),
  svg("text", { x: kEdge, y: 65, class: p.ill ? "bad" : "quiet" }, clipped(p.note, room, fontOfNote(p))));
  if (loaded)
    node.append(svg("rect", { class: "bar", x: kEdge, y: 76, width: room, height: 5, rx: 2.5 }),
      svg("rect", { class: p.load > 0.9 ? "bar full" : "bar used", x: kEdge, y: 76, height: 5, rx: 2.5,
        width: p.load ? Math.max(2, Math.min(1, p.load) * room) : 0 }));
  if (loaded && p.used?.part)
    node.append(svg("rect", { class: "bar now", x: kEdge, y: 83, height: 3, rx: 1.5, width: Math.max(2, Math.min(1, p.used.part) * room) }));
  return node;
}

function way(c, layout) {
  const { at } = layout;
  const end = lastHop(c);
  const group = svg("g", { class: `way ${c.granted ? (c.open ? "open" : "") : "stopped"}`, "aria-hidden": "true" });
  for (let i = 0; i < end; ++i) {
    if (!at.has(c.route[i]) || !at.has(c.route[i + 1])) return group;
    group.append(svg("polyline", { points: points(layout.line(c.route[i], c.route[i + 1])) }));
  }
  for (const name of c.route.slice(0, end + 1))
    if (at.has(name)) group.append(svg("rect", { ...at.get(name), height: kHeight, rx: 8 }));
  const [stop, next] = [c.route[end], c.route[end + 1]];
  if (!c.granted && at.has(stop) && at.has(next)) {
    const corners = layout.line(stop, next);
    const [[x1, y1], [x2, y2]] = corners;
    const part = 16 / (Math.hypot(x2 - x1, y2 - y1) || 1);
    // If other lines start with the same segment, the mark is at the corner where they part.
    const [x, y] = corners.length === 3 ? corners[1] : [x1 + (x2 - x1) * part, y1 + (y2 - y1) * part];
    group.append(svg("g", { transform: `translate(${x} ${y})` },
      svg("circle", { r: 11 }), svg("path", { d: "M-4.5 -4.5 L4.5 4.5 M4.5 -4.5 L-4.5 4.5" })));
  }
  return group;
}

/** `chosen`: the channel whose route is highlighted, or null. */
export function draw(graph, chosen, available, choose) {
  const edges = graph.edges.filter((e) => graph.places.has(e.a) && graph.places.has(e.b));
  const columns = asWide(graph.columns, edges, available);
  const wide = columns.width <= available + 60;
  const layout = wide ? columns : inTree(graph.columns, edges, available);
  const image = svg("svg", { viewBox: `-6 -6 ${layout.width + 12} ${layout.height + 12}`, class: "drawing", role: "group",
    "aria-label": `${many(graph.places.size, "network or gateway", "networks and gateways")}` });
  const room = { taken: [], lines: edges.map((e) => layout.line(e.a, e.b)) };
  image.append(...edges.map((e) => line(e, graph.places, layout)), ...graph.columns.flat().map((p) => box(p, layout.at, choose)),
    ...(chosen ? [way(chosen, layout)] : []), ...edges.map((e) => label(e, layout, room)).filter(Boolean));
  image.style.width = `min(100%, ${(layout.width + 12) * (wide ? Math.min(1.7, Math.max(1, available / 1500)) : 1)}px)`;
  return image;
}
