// SPDX-License-Identifier: BSD-2-Clause
// The script of the page of `mlccactl check --format html`: draws each system, and its channels in it.

const kOutcomes = { fit: "✓ fits", "run-time": "◌ decided at run time", unfit: "✕ does not fit" };

/** The graph of a map. Places are identified by their numbers, because a gateway may have the name of a network. */
function graphOfMap(map) {
  const places = new Map(map.places.map((p, i) => [String(i), { ...p, name: String(i), gateway: p.kind === undefined,
    subtitle: p.kind === undefined ? "gateway" : carries(p.kind, p), next: new Set(), order: 0 }]));
  map.places.forEach((p, i) => (p.next ?? []).forEach((n) => {
    places.get(String(i)).next.add(String(n));
    places.get(String(n)).next.add(String(i));
  }));
  // Deliveries within one network are on no line, so the note of the network counts them.
  const within = new Map();
  for (const way of map.ways) if (way.granted && way.route.length === 1) within.set(way.from, (within.get(way.from) ?? 0) + way.many);
  for (const [name, n] of within) {
    const p = places.get(name);
    p.note = [p.note, `${many(n, "delivery", "deliveries")} within`].filter(Boolean).join(", ");
  }
  return joined(places, map.ways);
}
const wayOf = (way) => ({ ...way, granted: way.outcome !== "unfit", open: way.outcome === "run-time", from: String(way.from), to: String(way.to),
  route: way.route.length ? way.route.map(String) : [String(way.from)], rows: way.stop === undefined ? [] : [{ outcome: "unfit", where: String(way.stop) }] });

class Sheet {
  constructor(place, map) {
    Object.assign(this, { place, prefix: place.dataset.prefix, chosen: null, width: 0 });
    this.graph = graphOfMap({ ...map, ways: this.ways = map.ways.map(wayOf) });
    this.caption = by(`${this.prefix}map`).querySelector(".chosen");
    this.links = [...place.closest("section").querySelectorAll("a[data-way]")];
    for (const link of this.links) link.addEventListener("click", (e) => { e.preventDefault(); this.choose(link); });
    if (this.links.length > 12) this.addFilter(this.links[0].closest("table"));
    new ResizeObserver(() => { if (place.clientWidth !== this.width) this.show(); }).observe(place);
    this.show();
  }
  show() {
    this.width = this.place.clientWidth;
    this.place.replaceChildren(draw(this.graph, this.chosen, this.width, (name) => this.open(name)));
  }
  /** Shows the table row that describes a network or gateway. */
  open(name) {
    const row = by(`${this.prefix}p${name}`);
    if (!row) return;
    row.tabIndex = -1;
    row.scrollIntoView({ block: "center" });
    row.focus({ preventScroll: true });
  }
  choose(link) {
    for (const one of this.links) one.toggleAttribute("aria-current", one === link);
    this.chosen = link && this.ways[link.dataset.way];
    this.show();
    if (!link) return this.caption.replaceChildren();
    const back = h("button", { type: "button", onclick: () => { this.choose(null); link.scrollIntoView({ block: "center" }); link.focus({ preventScroll: true }); } }, "Back to the table");
    const said = h("p", { tabindex: -1, role: "status" }, h("b", {}, link.textContent), " ",
      h("span", { class: `outcome ${this.chosen.outcome}` }, kOutcomes[this.chosen.outcome]), `: ${
        this.chosen.route.map((name) => this.graph.places.get(name).label).join(" › ")}`);
    this.caption.replaceChildren(said, back);
    this.place.parentElement.scrollIntoView({ block: "start" });
    said.focus({ preventScroll: true });
    return undefined;
  }
  addFilter(table) {
    const rows = [...table.tBodies[0].rows];
    const texts = [];
    const shown = h("span", { class: "quiet", role: "status" });
    const find = (text) => {
      let n = 0;
      rows.forEach((row, i) => {
        texts[i] ??= row.textContent.toLowerCase();
        row.hidden = !texts[i].includes(text);
        n += row.hidden ? 0 : 1;
      });
      shown.textContent = text ? `${count(n)} of ${count(rows.length)}` : "";
    };
    table.before(h("div", { class: "tools" }, h("label", {}, "Find ", h("input", { type: "search", oninput: (e) => find(e.target.value.trim().toLowerCase()) })), shown));
  }
}

const kMaps = JSON.parse(by("maps").textContent);
document.querySelectorAll(".map").forEach((place, i) => new Sheet(place, kMaps[i]));
document.body.dataset.ready = "1";
