// SPDX-License-Identifier: BSD-2-Clause
// Creates elements. Data from the daemon becomes text or the value of an attribute, never markup.

const kSvg = "http://www.w3.org/2000/svg";

function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return element;
}

export const h = (name, attributes = {}, ...children) =>
  fill(document.createElement(name), attributes, children);
export const svg = (name, attributes = {}, ...children) =>
  fill(document.createElementNS(kSvg, name), attributes, children);
/** A text whose end stays visible if there is no room for all of it (style.css). */
export function cut(text, end = 12) {
  const letters = [...text];
  return h("span", { class: "cut" }, h("span", {}, letters.slice(0, -end).join("")), h("span", {}, letters.slice(-end).join("")));
}
export const by = (id) => document.getElementById(id);
