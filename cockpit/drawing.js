// SPDX-License-Identifier: BSD-2-Clause
// The networks hop by hop. A channel is drawn along its route, from its first place to its last one, or to where
// it is refused.
import { svg } from "./dom.js";
import { bits, count, many, percent, rate } from "./format.js";
import { lastHop } from "./model.js";

const kWidth = 190, kHeight = 92, kGap = 110, kRow = 26;

function subtitle(p) {
  if (p.gateway) return p.own ? "this gateway" : "gateway";
  const can = p.interfaces.find((i) => i.bitrate);
  const rates = p.links.map((l) => l.believed_rate).filter((r) => r > 0);
  const of = can ? bits(can.bitrate)
    : rates.length ? `${many(rates.length, "link")}, ${bits(Math.min(...rates))} or more`
      : p.network.capacity ? rate(p.network.capacity) : "no rate stated";
  return `${p.network.kind}, ${of}`;
}
function thirdLine(p) {
  if (p.gateway) return "";
  if (!p.network.available) return p.network.problem || "not available";
  return p.interfaces.map((i) => {
    if (!i.ifindex) return `${i.name} is absent`;
    if (!i.up) return `${i.name} is down`;
    if (i.problem) return `${i.name}: ${i.problem}`;
    return `${i.name}${i.profile === "none" && !i.attached ? ", no gate" : i.attached ? ", gated" : ", NO GATE"}`;
  }).join("; ");
}
const isBad = (p) => !p.gateway && (!p.network.available
  || p.interfaces.some((i) => !i.ifindex || !i.up || i.problem || (!i.attached && i.profile !== "none")));
const clipped = (text, most) => (text.length > most ? `${text.slice(0, most - 1)}…` : text);

/** Whole numbers: where each place is. `tall`: from top to bottom, for a narrow screen. */
function layout(columns, tall) {
  const along = tall ? kHeight + 56 : kWidth + kGap;
  const across = tall ? kWidth + 20 : kHeight + kRow;
  const most = Math.max(1, ...columns.map((c) => c.length));
  const at = new Map();
  columns.forEach((column, i) => column.forEach((p, j) => {
    const a = i * along;
    const b = (j + (most - column.length) / 2) * across;
    at.set(p.name, tall ? { x: b, y: a } : { x: a, y: b });
  }));
  const length = columns.length * along - (along - (tall ? kHeight : kWidth));
  const width = most * across - (tall ? 20 : kRow);
  return { at, width: tall ? width : length, height: tall ? length : width };
}
const centre = ({ x, y }) => ({ x: x + kWidth / 2, y: y + kHeight / 2 });

/** From border to border. */
function between(a, b, tall) {
  const [p, q] = [centre(a), centre(b)];
  const sign = (n) => Math.sign(n);
  return tall && p.y !== q.y
    ? [p.x, p.y + sign(q.y - p.y) * kHeight / 2, q.x, q.y - sign(q.y - p.y) * kHeight / 2]
    : p.x === q.x ? [p.x, p.y + sign(q.y - p.y) * kHeight / 2, q.x, q.y - sign(q.y - p.y) * kHeight / 2]
      : [p.x + sign(q.x - p.x) * kWidth / 2, p.y, q.x - sign(q.x - p.x) * kWidth / 2, q.y];
}

function edge({ a, b, granted, refused }, at, tall) {
  const [x1, y1, x2, y2] = between(at.get(a), at.get(b), tall);
  const [x, y] = [(x1 + x2) / 2, (y1 + y2) / 2];
  const group = svg("g", { class: `edge ${granted ? "" : "idle"}` },
    svg("title", {}, `${a} and ${b}: ${many(granted, "delivery", "deliveries")} granted, ${count(refused)} refused`),
    svg("line", { x1, y1, x2, y2, "stroke-width": granted ? Math.min(10, 2 + 2 * Math.log10(granted)) : 1.5 }));
  const side = tall ? { dx: 8, anchor: "start", up: -2, down: 14 } : { dx: 0, anchor: "middle", up: -9, down: 20 };
  if (granted) group.append(svg("text", { x: x + side.dx, y: y + side.up, "text-anchor": side.anchor, class: "good" }, `✓ ${count(granted)}`));
  if (refused) group.append(svg("text", { x: x + side.dx, y: y + side.down, "text-anchor": side.anchor, class: "bad" }, `✕ ${count(refused)}`));
  return group;
}

function box(p, at, choose) {
  const { x, y } = at.get(p.name);
  const bad = isBad(p);
  const lines = [clipped(p.name, 20), clipped(subtitle(p), 28), clipped(thirdLine(p), 28)];
  const full = `${p.name}: ${subtitle(p)}. ${thirdLine(p)}${p.load === null || p.load === undefined ? "" : `, ${percent(p.load)} reserved`}`;
  const node = svg("g", { class: `place ${p.gateway ? "gateway" : ""} ${bad ? "ill" : ""}`, tabindex: 0, role: "button",
    "aria-label": full, transform: `translate(${x} ${y})`, onclick: () => choose(p.name),
    onkeydown: (e) => { if (e.key === "Enter" || e.key === " ") { e.preventDefault(); choose(p.name); } } },
  svg("title", {}, full),
  svg("rect", { width: kWidth, height: kHeight, rx: p.gateway ? 20 : 6 }),
  svg("text", { x: 14, y: 27, class: "name" }, lines[0]),
  svg("text", { x: 14, y: 47, class: "quiet" }, lines[1]),
  svg("text", { x: 14, y: 65, class: bad ? "bad" : "quiet" }, lines[2]));
  if (p.load !== null && p.load !== undefined)
    node.append(svg("rect", { class: "bar", x: 14, y: 76, width: kWidth - 28, height: 5, rx: 2.5 }),
      svg("rect", { class: p.load > 0.9 ? "bar full" : "bar used", x: 14, y: 76, height: 5, rx: 2.5,
        width: p.load ? Math.max(2, Math.min(1, p.load) * (kWidth - 28)) : 0 }));
  return node;
}

function way(c, at, tall) {
  const end = lastHop(c);
  const group = svg("g", { class: `way ${c.granted ? "" : "stopped"}`, "aria-hidden": "true" });
  for (let i = 0; i < end; ++i) {
    const [a, b] = [at.get(c.route[i]), at.get(c.route[i + 1])];
    if (!a || !b) return group;
    const [x1, y1, x2, y2] = between(a, b, tall);
    group.append(svg("line", { x1, y1, x2, y2 }));
  }
  for (const name of c.route.slice(0, end + 1))
    if (at.has(name)) group.append(svg("rect", { ...at.get(name), width: kWidth, height: kHeight, rx: 8 }));
  const [stop, next] = [at.get(c.route[end]), at.get(c.route[end + 1])];
  if (!c.granted && stop && next) {
    const [x1, y1, x2, y2] = between(stop, next, tall);
    const length = Math.hypot(x2 - x1, y2 - y1) || 1;
    group.append(svg("g", { transform: `translate(${x1 + (x2 - x1) / length * 16} ${y1 + (y2 - y1) / length * 16})` },
      svg("circle", { r: 11 }), svg("path", { d: "M-4.5 -4.5 L4.5 4.5 M4.5 -4.5 L-4.5 4.5" })));
  }
  return group;
}

/** `chosen`: the channel whose way is shown, or none. */
export function draw(graph, chosen, available, choose) {
  const tall = available < graph.columns.length * (kWidth + kGap) - kGap - 60;
  const { at, width, height } = layout(graph.columns, tall);
  const image = svg("svg", { viewBox: `-6 -6 ${width + 12} ${height + 12}`, class: "drawing", role: "group",
    "aria-label": `${many(graph.places.size, "network or gateway", "networks and gateways")}` });
  image.append(...graph.edges.filter((e) => at.has(e.a) && at.has(e.b)).map((e) => edge(e, at, tall)),
    ...graph.columns.flat().map((p) => box(p, at, choose)), ...(chosen ? [way(chosen, at, tall)] : []));
  image.style.width = `min(100%, ${(width + 12) * Math.min(1.7, Math.max(1, available / 1500))}px)`;
  return image;
}
