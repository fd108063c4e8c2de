// SPDX-License-Identifier: BSD-2-Clause
// A grid in which only the visible rows are elements, so that 1,000 rows cost as much as 30. For printing, and in a
// file that a browser searches, all rows are elements.
import { h } from "./dom.js";

const kRowHeight = 48; // px
const kBeyond = 6; // number of rows above and below the visible ones

export class List {
  /** `cells(row)` makes the cells of a row. `columns`: class and name of each. `every`: all rows are elements. */
  constructor({ label, columns, cells, open, every = false }) {
    Object.assign(this, { columns, cells, open, height: kRowHeight, every, rows: [], at: 0, shown: new Map() });
    this.body = h("div", { class: "rows", role: "presentation" });
    this.scroller = h("div", { class: "scroller", role: "rowgroup", onscroll: () => this.later() }, this.body);
    this.element = h("div", { class: "list", role: "grid", "aria-label": label, onkeydown: (e) => this.key(e) },
      h("div", { class: "row head", role: "row", "aria-rowindex": 1 },
        columns.map(([kind, name]) => h("div", { role: "columnheader", class: kind }, name))),
      this.scroller);
    new ResizeObserver(() => this.resized()).observe(this.scroller);
  }
  /** The height of a row in px. The width decides how many lines a row has (style.css). */
  measured() {
    const said = parseFloat(getComputedStyle(this.element).getPropertyValue("--row"));
    return said * parseFloat(getComputedStyle(document.documentElement).fontSize) || kRowHeight;
  }
  /** Keeps the same rows visible and the same elements, because one may have the focus or get it back. */
  resized() {
    const first = this.scroller.scrollTop / this.height;
    const height = this.measured();
    if (height !== this.height) {
      this.height = height;
      this.stretch();
      for (const [i, element] of this.shown) this.put(i, element);
      this.scroller.scrollTop = first * height;
    }
    this.later();
  }
  stretch() { this.body.style.height = this.every ? "" : `${this.rows.length * this.height}px`; }
  put(i, element) { if (!this.every) element.style.transform = `translateY(${Math.round(i * this.height)}px)`; }
  show(rows) {
    this.rows = rows;
    this.height = this.measured();
    this.at = Math.min(this.at, Math.max(0, rows.length - 1));
    this.element.setAttribute("aria-rowcount", rows.length + 1);
    this.element.classList.toggle("every", this.every);
    this.stretch();
    const focused = this.body.contains(document.activeElement);
    this.clear();
    this.paint();
    if (focused) this.shown.get(this.at)?.focus();
  }
  clear() {
    this.body.replaceChildren();
    this.shown.clear();
  }
  /** Makes all rows elements, or only the visible ones. */
  all(every) {
    this.every = every;
    this.show(this.rows);
  }
  /** Updates the text of the same rows. */
  update() {
    for (const [i, element] of this.shown)
      this.cells(this.rows[i]).forEach((cell, n) => {
        const there = element.children[n];
        if (there.textContent === (cell.textContent ?? cell)) return;
        there.replaceChildren(cell);
        there.title = there.textContent;
      });
  }
  later() {
    this.due ??= requestAnimationFrame(() => {
      this.due = undefined;
      this.paint();
    });
  }
  paint() {
    const top = this.scroller.scrollTop;
    const first = this.every ? 0 : Math.max(0, Math.floor(top / this.height) - kBeyond);
    const last = this.every ? this.rows.length : Math.min(this.rows.length, Math.ceil((top + (this.scroller.clientHeight || 480)) / this.height) + kBeyond);
    for (const [i, element] of this.shown)
      if ((i < first || i >= last) && i !== this.at) {
        element.remove();
        this.shown.delete(i);
      }
    for (let i = first; i < last; ++i) if (!this.shown.has(i)) this.add(i);
    if (this.rows.length && !this.shown.has(this.at)) this.add(this.at);
  }
  add(i) {
    const row = h("div", { class: `row ${this.rows[i].state ?? ""}`, role: "row", "aria-rowindex": i + 2,
      tabindex: i === this.at ? 0 : -1, onclick: () => this.choose(i, true) },
    this.cells(this.rows[i]).map((cell, n) => h("div", { role: "gridcell", class: this.columns[n][0], title: cell.textContent ?? cell }, cell)));
    this.put(i, row);
    this.shown.set(i, row);
    this.body.append(row);
  }
  choose(i, open) {
    this.shown.get(this.at)?.setAttribute("tabindex", -1);
    this.at = i;
    const y = this.every ? this.shown.get(i).offsetTop : i * this.height;
    const { scrollTop, clientHeight } = this.scroller;
    if (y < scrollTop) this.scroller.scrollTop = y;
    else if (y + this.height > scrollTop + clientHeight) this.scroller.scrollTop = y + this.height - clientHeight;
    this.paint();
    const row = this.shown.get(i);
    row.setAttribute("tabindex", 0);
    row.focus({ preventScroll: true });
    if (open) this.open(this.rows[i]);
  }
  key(e) {
    const page = Math.max(1, Math.floor(this.scroller.clientHeight / this.height) - 1);
    const steps = { ArrowDown: 1, ArrowUp: -1, PageDown: page, PageUp: -page, Home: -Infinity, End: Infinity };
    if (!this.rows.length) return;
    if (e.key in steps) this.choose(Math.min(this.rows.length - 1, Math.max(0, this.at + steps[e.key])), false);
    else if (e.key === "Enter" || e.key === " ") this.choose(this.at, true);
    else return;
    e.preventDefault();
  }
}
