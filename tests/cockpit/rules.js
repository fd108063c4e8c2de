// SPDX-License-Identifier: BSD-2-Clause
// Finds what is wrong with a page for users of keyboards, screen readers or other colour schemes, as far as a program
// can see it (WCAG 2.2 AA). This is the body of a function that returns lines. browser.py compares names and roles with
// the accessibility tree of the browser.
const wrong = [];
const outline = (e) => e.outerHTML.slice(0, 110);
const shown = (e) => e.checkVisibility({ checkOpacity: true, checkVisibilityCSS: true });
const all = (selector) => [...document.querySelectorAll(selector)].filter(shown);

// --- colours ------------------------------------------------------------------------------------

const numbers = (colour) => {
  const [r, g, b, a = 1] = (colour.match(/[\d.]+/g) || [0, 0, 0, 0]).map(Number);
  return { rgb: [r, g, b], a };
};
const over = (top, ground, a) => top.map((v, i) => v * a + ground[i] * (1 - a));
const luminance = (rgb) => {
  const [r, g, b] = rgb.map((v) => { const s = v / 255; return s <= .03928 ? s / 12.92 : ((s + .055) / 1.055) ** 2.4; });
  return .2126 * r + .7152 * g + .0722 * b;
};
const ratio = (one, two) => {
  const [light, dark] = [luminance(one), luminance(two)].sort((x, y) => y - x);
  return (light + .05) / (dark + .05);
};
/** The colour behind an element: its own background, if it has one, over those of its ancestors. */
function ground(e) {
  const layers = [];
  for (; e; e = e.parentElement) {
    const { rgb, a } = numbers(getComputedStyle(e).backgroundColor);
    if (a > 0) layers.push({ rgb, a });
    if (a === 1) break;
  }
  return layers.reduceRight((below, { rgb, a }) => over(rgb, below, a), [255, 255, 255]);
}
/** The colour behind a text in a drawing: the shapes under its centre that were drawn before it. */
function drawnBehind(text) {
  const drawing = text.closest("svg"), box = text.getBoundingClientRect();
  const x = box.left + box.width / 2, y = box.top + box.height / 2;
  let below = ground(drawing);
  for (const shape of drawing.querySelectorAll("rect, circle")) {
    if (!(shape.compareDocumentPosition(text) & Node.DOCUMENT_POSITION_FOLLOWING)) break;
    const style = getComputedStyle(shape), area = shape.getBoundingClientRect();
    if (style.fill === "none" || x < area.left || x > area.right || y < area.top || y > area.bottom) continue;
    const { rgb, a } = numbers(style.fill);
    below = over(rgb, below, a * style.fillOpacity * style.opacity);
  }
  return below;
}
const opacity = (e) => { let all_ = 1; for (; e; e = e.parentElement) all_ *= getComputedStyle(e).opacity; return all_; };
for (const e of all("body *")) {
  if (e.closest(".unseen") || e.disabled || ![...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim())) continue;
  const style = getComputedStyle(e), drawn = e.closest("svg");
  const behind = drawn ? drawnBehind(e) : ground(e);
  const { rgb, a } = numbers(drawn ? style.fill : style.color);
  const size = parseFloat(style.fontSize);
  const least = size >= 24 || (size >= 18.66 && style.fontWeight >= 700) ? 3 : 4.5;
  const found = ratio(over(rgb, behind, a * opacity(e)), behind);
  if (found < least) wrong.push(`contrast ${found.toFixed(2)}: ${e.textContent.slice(0, 40)}`);
}
// Controls must be visible, by their border or their background.
for (const e of all("button, input:not([type=checkbox]), select")) {
  const style = getComputedStyle(e), behind = ground(e.parentElement);
  const border = parseFloat(style.borderTopWidth) || parseFloat(style.borderBottomWidth) ? ratio(numbers(style.borderBottomColor).rgb, behind) : 1;
  if (Math.max(border, ratio(ground(e), behind)) < 3 && !e.textContent.trim()) wrong.push(`a control that is not seen: ${outline(e)}`);
}

// --- words --------------------------------------------------------------------------------------

const object = /.{0,40}\[object .{0,40}/.exec(document.body.innerText);
if (object) wrong.push(`a value that is no text: ${object[0]}`);
for (const e of document.querySelectorAll("[title], [aria-label]"))
  if (/\[object /.test(`${e.title}${e.ariaLabel}`)) wrong.push(`a value that is no text: ${outline(e)}`);
// A text of several letters must be wider than one letter.
for (const e of all("dd, dt, td, th")) {
  const { width } = e.getBoundingClientRect();
  if (e.textContent.length > 3 && width < 1.5 * parseFloat(getComputedStyle(e).fontSize)) wrong.push(`${Math.round(width)} px for ${e.textContent.slice(0, 40)}`);
}

// --- structure ----------------------------------------------------------------------------------

const kOperated = "button, input, select, textarea, summary, a[href], [role=button], [role=tab], [role=gridcell][tabindex]";
for (const e of all(kOperated)) {
  const box = e.getBoundingClientRect();
  const inText = e.matches("a[href], summary") || e.closest("label");
  if (!inText && (box.width < 24 || box.height < 24)) wrong.push(`${Math.round(box.width)}x${Math.round(box.height)} px to hit: ${outline(e)}`);
  if (e.parentElement?.closest(kOperated)) wrong.push(`a control in a control: ${outline(e)}`);
}
for (const e of document.querySelectorAll("[tabindex]")) if (e.tabIndex > 0) wrong.push(`an order of its own: ${outline(e)}`);
const ids = new Set();
for (const { id } of document.querySelectorAll("[id]")) {
  if (ids.has(id)) wrong.push(`two elements have the id ${id}`);
  ids.add(id);
}
for (const name of ["aria-controls", "aria-labelledby", "aria-describedby", "aria-owns"])
  for (const e of all(`[${name}]`))
    for (const id of e.getAttribute(name).split(" ")) if (!document.getElementById(id)) wrong.push(`${name} of ${outline(e)} leads nowhere`);
if (!document.documentElement.lang) wrong.push("no language");
if (!document.title) wrong.push("no title");
if (document.querySelectorAll("main, [role=main]").length !== 1) wrong.push("not one main part");
let level = 0;
for (const e of all("h1, h2, h3, h4, h5, h6")) {
  const now = Number(e.tagName[1]);
  if (now > level + 1) wrong.push(`${e.tagName} behind H${level}: ${e.textContent.slice(0, 40)}`);
  level = now;
}
const kWithin = { "[role=tab]": "[role=tablist]", "[role=row]": "[role=grid], [role=table]", "[role=gridcell], [role=columnheader]": "[role=row]",
  "li": "ul, ol", "dt, dd": "dl", "th, td": "tr", "option": "select, datalist" };
for (const [inner, outer] of Object.entries(kWithin))
  for (const e of all(inner)) if (!e.closest(outer)) wrong.push(`${inner} in no ${outer}: ${outline(e)}`);
for (const e of all("ul > *, ol > *")) if (!e.matches("li, script, template")) wrong.push(`no item of a list: ${outline(e)}`);
for (const e of all("th")) if (!e.scope) wrong.push(`a heading of what? ${outline(e)}`);
for (const tabs of all("[role=tablist]")) {
  if (tabs.querySelectorAll("[role=tab][aria-selected=true]").length !== 1) wrong.push("not one tab is chosen");
  if (tabs.querySelectorAll("[role=tab][tabindex='0']").length !== 1) wrong.push("not one tab is in the order of Tab");
}
for (const e of all("[role=row][aria-rowindex]"))
  if (Number(e.getAttribute("aria-rowindex")) > Number(e.closest("[aria-rowcount]")?.getAttribute("aria-rowcount") ?? 0)) wrong.push(`more rows than there are: ${outline(e)}`);
// Everything that scrolls must be scrollable by keyboard.
for (const e of all("body *")) {
  const style = getComputedStyle(e);
  const scrolls = (/auto|scroll/.test(style.overflowY) && e.scrollHeight > e.clientHeight + 1) || (/auto|scroll/.test(style.overflowX) && e.scrollWidth > e.clientWidth + 1);
  if (scrolls && e.tabIndex < 0 && ![...e.querySelectorAll("*")].some((inner) => inner.tabIndex >= 0 && shown(inner))) wrong.push(`no key scrolls ${outline(e)}`);
}
if (document.documentElement.scrollWidth > innerWidth) wrong.push(`wider than the page: ${document.documentElement.scrollWidth}`);
return [...new Set(wrong)];
