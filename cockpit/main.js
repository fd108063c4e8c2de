// SPDX-License-Identifier: BSD-2-Clause
// The page: when it asks what, and where it shows the answers.
/* global cockpit */
import { ask, follow, followCounters, kLive } from "./ask.js";
import { admit, changeMode, reinstate, release, reload, withdraw } from "./changes.js";
import { clusterParts } from "./cluster.js";
import { Counters } from "./counters.js";
import { asOf, channelDetail, channelFacts, placeDetail, placeFacts, silence, verdict } from "./detail.js";
import { by, cut, h, svg } from "./dom.js";
import { draw } from "./drawing.js";
import { count, forPeople, many, moment, passed, percent } from "./format.js";
import { List } from "./list.js";
import { banner, Counted, findingName, graphOf, key, kStates, marginOf, sorted, used } from "./model.js";

const kFindings = 200; // most findings that are shown
const kEntries = 200; // entries of the history that are shown, and that are asked for without a search
const kSearched = 10000; // entries that are asked for with a search: the most that mlccactl gives
const kSamples = 240; // most samples of a resource, since the page was opened
const kLoud = ["withdrawn", "revoked", "network-down", "removed", "refused", "missing", "lapsed", "drift", "bypass", "mode", "problem"];
const now = { status: null, networks: [], channels: [], reservations: [], routes: { links: [] }, history: [], audit: null, cluster: null, members: null, taken_there: null, live: false, taken: 0, health_taken: 0, health_asked: false,
  counted: new Counted() };
const samples = new Map();
const kSettles = 5e9; // ns between two counters from which on their difference shows the use
const counters = new Counters();
let chosen = null; // key of the channel whose detail is open
let chosenPlace = null; // name of the place whose detail is open
let opened = null; // element that had the focus before

const put = (id, ...children) => by(id).replaceChildren(...children.flat().filter((c) => c !== null));
const say = (text) => { by("said").textContent = text; };

// --- the first five seconds: is it safe, and if not, why ------------------------------------------

const kHealth = {
  healthy: ["good", "✓", "Everything is as described"], degraded: ["warn", "!", "Something needs attention"],
  closed: ["bad", "✕", "Closed: everything is denied"], unknown: ["warn", "?", "The health is not known"],
};

function showHealth(problem) {
  const { status } = now;
  const header = by("health");
  if (!status) {
    header.className = "health bad";
    put("verdict", h("span", { class: "mark", "aria-hidden": "true" }, "✕"), "No daemon answers");
    put("reasons", h("li", {}, problem));
    by("reasons").hidden = false;
    by("health-taken").hidden = true;
    return put("figures");
  }
  const [look, mark, text] = kHealth[status.health.state];
  header.className = `health ${look}`;
  header.querySelector("h1").textContent = `${status.gateway} of ${status.system}`;
  const verdictText = `${mark}${text}`;
  if (by("verdict").textContent !== verdictText) put("verdict", h("span", { class: "mark", "aria-hidden": "true" }, mark), text);
  const reasons = banner(status.health.reasons.map(forPeople), status.health.left_out).map((r) => h("li", {}, r));
  if (by("reasons").textContent !== reasons.map((r) => r.textContent).join("")) put("reasons", reasons);
  by("reasons").hidden = by("health-taken").hidden = !reasons.length;
  by("health-taken").textContent = `as of ${moment(now.health_taken)}`;
  const silent = now.channels.filter((c) => c.state === "silent").length;
  const figure = (name, text_, look_ = "", id = null) => h("div", { class: look_ }, h("dt", {}, name), h("dd", { id }, text_));
  put("figures", figure("granted", count(status.channels_granted)),
    figure("refused", count(status.channels_refused), status.channels_refused ? "bad" : ""),
    figure("silent", count(silent), silent ? "bad" : ""),
    figure("mode", status.mode, status.mode === "audit" ? "bad" : ""),
    kLive ? figure("events", now.live ? "live" : "not live", now.live ? "" : "bad") : null,
    now.taken ? figure("counters as of", moment(now.taken), "", "taken") : null);
  if (kLive && (!by("actions").childElementCount || by("actions").dataset.mode !== status.mode)) {
    by("actions").dataset.mode = status.mode;
    const button = (label, run) => h("button", { type: "button", onclick: run }, label);
    put("actions", button(status.mode === "audit" ? "Enforce…" : "Audit mode…", () => changeMode(now.status.mode)),
      button("Admit…", () => admit(now.channels.map((c) => c.name), [...graphOf(now).places.keys()])), button("Reload…", reload));
  }
}

// --- the map --------------------------------------------------------------------------------------

function showMap() {
  const channel = now.channels.find((c) => key(c) === chosen);
  const focused = by("map").contains(document.activeElement) ? document.activeElement.dataset.place : undefined;
  put("map", now.networks.length ? draw(graphOf(now), channel, by("map").clientWidth, openPlace)
    : h("p", { class: "quiet" }, "No network is described."));
  if (focused !== undefined) [...by("map").querySelectorAll("[role=button]")].find((b) => b.dataset.place === focused)?.focus();
}

// --- details --------------------------------------------------------------------------------------

function openDetail(title, content, keep) {
  const detail = by("detail");
  if (detail.hidden) opened = document.activeElement;
  detail.hidden = false;
  document.body.classList.add("with-detail");
  put("detail", h("div", { class: "detail-head" }, h("h2", { id: "detail-title" }, title),
    h("button", { type: "button", class: "close", "aria-label": "Close the details", onclick: closeDetail }, "✕")), content);
  if (!keep) detail.focus({ preventScroll: true });
}
function closeDetail() {
  by("detail").hidden = true;
  document.body.classList.remove("with-detail");
  chosen = null;
  chosenPlace = null;
  showMap();
  opened?.focus();
}
function openPlace(name) {
  chosen = null;
  chosenPlace = name;
  showMap();
  openDetail(name, placeDetail(graphOf(now).places.get(name), now.reservations));
}
function openChannel(c, keep = false) {
  chosen = key(c);
  chosenPlace = null;
  const button = (label, run) => h("button", { type: "button", onclick: run }, label);
  openDetail(`${c.name}: ${c.from} to ${c.to}`, channelDetail(c, !kLive ? [] : [
    c.withdrawn ? button("Reinstate…", () => reinstate(c.name)) : button("Withdraw…", () => withdraw(c.name)),
    c.admission ? button("Release…", () => release(c)) : null].filter(Boolean), now.taken), keep);
  showMap();
}

// --- tabs -----------------------------------------------------------------------------------------

const filter = { text: "", state: "all" };
const whyOf = (c) => h("span", {}, forPeople(c.problems[0] ?? c.reason));
const list = new List({
  label: "Deliveries", open: (c) => openChannel(c), every: !kLive,
  columns: [["state", "Verdict"], ["name", "Channel"], ["ends", "Route"], ["why", "Reason"], ["margin", "Margin"], ["number passed", "Passed"], ["number dropped", "Dropped"],
    ["number would", "Would drop"], ["events", "Events"]],
  cells: (c) => [verdict(c.state), cut(c.name), h("span", {}, cut(c.from, 8), " › ", cut(c.to, 8)), whyOf(c), marginOf(c), passed(c), count(c.dropped),
    c.would_drop ? count(c.would_drop) : "", silence(c)],
});

function showChannels() {
  const text = filter.text.toLowerCase();
  list.show(now.channels.filter((c) => (filter.state === "all" || (filter.state === "attention" ? kStates[c.state].bad : c.granted === (filter.state === "granted")))
    && (!text || `${c.name} ${c.publisher} ${c.from} ${c.to} ${c.subject}`.toLowerCase().includes(text))));
  by("shown").textContent = `${count(list.rows.length)} of ${count(now.channels.length)}`;
}

function channelsPanel() {
  return [h("div", { class: "tools" },
    h("label", {}, "Find ", h("input", { type: "search", oninput: (e) => { filter.text = e.target.value; showChannels(); } })),
    h("label", {}, "Show ", h("select", { onchange: (e) => { filter.state = e.target.value; showChannels(); } },
      ["all", "attention", "granted", "refused"].map((value) => h("option", { value }, value === "attention" ? "what needs attention" : value)))),
    h("span", { id: "shown", class: "quiet", role: "status" })), list.element];
}

/** A line chart of the reserved share and, where it is known, of the used share. */
function spark(points) {
  const width = 240, height = 36;
  const first = points[0].at, span = Math.max(1, points.at(-1).at - first);
  const line = (of, what) => {
    const path = of.map((p) => `${((p.at - first) / span * width).toFixed(1)},${(height - 2 - Math.min(1, p[what]) * (height - 4)).toFixed(1)}`);
    return svg("polyline", { class: what, points: of.length > 1 ? path.join(" ") : `0,${path[0].split(",")[1]} ${width},${path[0].split(",")[1]}` });
  };
  const known = points.filter((p) => p.used !== null);
  const said = (of, what, word) => `${word} from ${percent(of[0][what])} to ${percent(of.at(-1)[what])}`;
  return svg("svg", { viewBox: `0 0 ${width} ${height}`, class: "spark", role: "img", preserveAspectRatio: "none",
    "aria-label": `${said(points, "part", "reserved")}${known.length ? `, ${said(known, "used", "used")}` : ""} since the page was opened` },
  line(points, "part"), known.length ? line(known, "used") : null);
}
/** The used share in words. Not measured are events that do not enter here by a gate, and those without a Period. */
function usedWords(resource) {
  const now_ = used(resource, now.counted);
  if (!now_) return resource.reservations.length ? "; no event of these is counted here" : "";
  return `; ${percent(now_.part)} used${now_.measured < now_.of ? ` by the ${count(now_.measured)} of ${many(now_.of, "reservation")} whose events are counted here` : ""}`;
}
function reservedPanel() {
  const known = now.reservations.filter((r) => r.capacity);
  if (!known.length) return [h("p", { class: "quiet" }, "No resource has a capacity that is known.")];
  return [h("ul", { class: "resources" }, known.map((r) => {
    const part = r.reserved / r.capacity;
    const taken = r.background / r.capacity;
    const meter = h("div", { class: "meter", role: "img", "aria-label": `${percent(part)} reserved, ${percent(taken)} taken by others` }, h("span", { class: "used" }), h("span", { class: "others" }));
    meter.children[0].style.width = `${Math.min(1, part) * 100}%`;
    meter.children[1].style.width = `${Math.min(1 - Math.min(1, part), taken) * 100}%`;
    const top = [...r.reservations].sort((a, b) => b.amount - a.amount);
    return h("li", {}, h("h3", {}, r.name, h("span", { class: "quiet" }, ` ${r.kind}`)), meter,
      h("p", {}, `${percent(part)} reserved${taken ? `, ${percent(taken)} taken by others` : ""}${usedWords(r)}`), spark(samples.get(`${r.kind} ${r.name}`)),
      top.length ? h("details", {}, h("summary", {}, many(top.length, "reservation")), h("ol", {}, top.slice(0, 50).map((one) =>
        h("li", {}, `${one.channel} of ${one.publisher}: ${percent(one.amount / r.capacity)}`))),
      top.length > 50 ? h("p", { class: "quiet" }, `and ${count(top.length - 50)} smaller ones`) : "") : null);
  }))];
}
const past = { text: "", people: false };
const pastAsked = () => String(past.text || past.people ? kSearched : kEntries);
let searching;
/** Shows the entries that are there, and asks for older ones. */
function search() {
  showHistory();
  clearTimeout(searching);
  searching = setTimeout(async () => {
    try {
      now.history = (await ask("history", "--limit", pastAsked())).entries;
      showHistory();
    } catch (problem) {
      say(problem.message);
    }
  }, 300);
}
function showHistory() {
  const text = past.text.toLowerCase();
  const found = now.history.filter((e) => (!past.people || e.client)
    && (!text || `${e.kind} ${e.channel} ${e.from} ${e.to} ${e.network} ${e.message}`.toLowerCase().includes(text)));
  put("past", found.length ? h("ol", { class: "history" }, found.slice(0, kEntries).map((e) => h("li", {},
    h("time", { datetime: new Date(e.unix_ns / 1e6).toISOString() }, moment(e.unix_ns)), h("span", { class: `kind ${e.kind}` }, e.kind),
    h("span", { class: "message" }, e.message))))
    : h("p", { class: "quiet" }, now.history.length ? "No entry is like that." : "Nothing has been decided yet."));
  by("past-shown").textContent = `${count(Math.min(found.length, kEntries))} of the latest ${count(now.history.length)}`;
}
function historyPanel() {
  return [h("div", { class: "tools" },
    h("label", {}, "Find ", h("input", { type: "search", id: "past-text", oninput: (e) => { past.text = e.target.value; search(); } })),
    h("label", { class: "tick" }, h("input", { type: "checkbox", id: "past-people", onchange: (e) => { past.people = e.target.checked; search(); } }), "changes by people only"),
    h("span", { id: "past-shown", class: "quiet", role: "status" })), h("div", { id: "past" })];
}
function auditPanel() {
  const { audit } = now;
  if (!audit?.findings.length) return [h("p", { class: "quiet" }, "Nothing was refused.")];
  const frames = (f, number) => `${f.at_least ? "at least " : ""}${many(number, "frame")}`;
  const way = (f) => f.others && !f.channel ? "on" : f.egress ? "to" : "from";
  const lines = (f) => [
    h("p", {}, [f.would_drop ? `${frames(f, f.would_drop)} would have been dropped` : null, f.dropped ? `${frames(f, f.dropped)} dropped` : null]
      .filter(Boolean).join(", ") + ` ${way(f)} ${f.interface}${f.sender ? `, sent by ${f.sender}` : ""}: ${f.reason}`),
    h("p", { class: "quiet" }, `since ${moment(f.first_unix_s * 1e9)}, latest ${moment(f.last_unix_s * 1e9)}`),
    f.advice ? h("p", {}, f.advice) : null,
    f.add ? h("details", {}, h("summary", {}, `Add ${findingName(f)}`), h("pre", { tabindex: 0, "aria-label": `XML for ${findingName(f)}` }, f.add),
      h("button", { type: "button", onclick: async (e) => { await navigator.clipboard.writeText(f.add); e.target.textContent = "Copied"; say("Copied"); } }, "Copy")) : null];
  return [h("p", {}, "What the gates have refused, or would have refused in audit mode. To admit some of it, add what is shown to the description."),
    h("ul", { class: "found" }, audit.findings.slice(0, kFindings).map((f) => h("li", {}, h("h3", {}, `${findingName(f)} on ${f.network}`), lines(f)))),
    audit.findings.length > kFindings ? h("p", { class: "quiet" }, `and ${count(audit.findings.length - kFindings)} with fewer frames`) : ""];
}

// By tab: its label, its content, and what updates it. Panels with input fields are not made again.
const kTabs = { channels: ["Channels", channelsPanel, showChannels], reserved: ["Reserved", reservedPanel],
  history: ["History", historyPanel, showHistory], found: ["Refused", auditPanel],
  cluster: ["Cluster", () => clusterParts(now.cluster, now.members, now.taken_there)] };
let tab = "channels";
function openTab(name, focus) {
  tab = name;
  for (const one of Object.keys(kTabs)) {
    by(`tab-${one}`).setAttribute("aria-selected", one === name);
    by(`tab-${one}`).tabIndex = one === name ? 0 : -1;
    by(`panel-${one}`).hidden = one !== name;
  }
  if (focus) by(`tab-${name}`).focus();
  showTab();
  if (name === "cluster" && now.cluster?.system && !now.taken_there) refresh();
}
function showTab(name = tab) {
  const [, panel, show] = kTabs[name];
  if (show) return show();
  const open = [...by(`panel-${name}`).querySelectorAll("details")].map((d) => d.open);
  if (by(`panel-${name}`).contains(document.activeElement)) return undefined; // do not disturb a user in the panel
  put(`panel-${name}`, panel());
  by(`panel-${name}`).querySelectorAll("details").forEach((d, i) => { d.open = open[i] ?? false; });
  return undefined;
}
/** Prepares for printing, where nothing can be opened or scrolled. */
function forPaper() {
  for (const name of Object.keys(kTabs)) if (now.status) showTab(name);
  list.all(true);
  for (const d of document.querySelectorAll("details")) d.open = true;
}
function makeTabs() {
  const names = Object.keys(kTabs);
  put("tabs", names.map((name, i) => h("button", { type: "button", role: "tab", id: `tab-${name}`, "aria-controls": `panel-${name}`,
    onclick: () => openTab(name), onkeydown: (e) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[e.key];
      if (step) openTab(names[(i + step + names.length) % names.length], true);
    } }, kTabs[name][0])));
  put("panels", names.map((name) => h("section", { role: "tabpanel", id: `panel-${name}`, "aria-labelledby": `tab-${name}`, class: "card", "data-title": kTabs[name][0] },
    kTabs[name][2] ? kTabs[name][1]() : [])));
  openTab("channels");
}

// --- asking ---------------------------------------------------------------------------------------

/** Samples how much of each reserved resource is used, from the counters. */
function settle() {
  now.counted.take(now.channels, now.taken);
  now.settled = now.taken;
  for (const r of now.reservations) if (r.capacity) {
    const name = `${r.kind} ${r.name}`;
    const line = samples.get(name) ?? [];
    samples.set(name, [...line, { at: Date.now(), part: r.reserved / r.capacity, used: used(r, now.counted)?.part ?? null }].slice(-kSamples));
  }
}
/** Updates only visible elements, and only those whose text changes. */
function showCounters() {
  const other = (there, fresh) => { if (there && there.textContent !== fresh.textContent) there.replaceWith(fresh); };
  list.update();
  if (by("taken")) by("taken").textContent = moment(now.taken);
  const open = chosen && now.channels.find((c) => key(c) === chosen);
  if (open) {
    other(by("as-of"), asOf(now.taken));
    other(by("detail").querySelector(".facts"), channelFacts(open));
  }
  const place = chosenPlace && graphOf(now).places.get(chosenPlace);
  if (place) other(by("detail").querySelector(".facts"), placeFacts(place, now.reservations));
  if (now.taken - now.settled < kSettles) return;
  settle();
  showMap();
  if (tab === "reserved") showTab();
}

let asking = false, again = false, due;
/**
 * An older mlccad does not know these questions. The reservations may be long, so they are asked for only when shown.
 */
function askCluster() {
  const shown = tab === "cluster" || !kLive;
  return ["status", "members", shown ? "reservations" : null].map((part) => part && ask("cluster", part).catch(() => null));
}
/** Asks for everything. The status comes first, so that the important part is visible while the rest is loading. */
async function refresh() {
  clearTimeout(due);
  if (asking) { again = true; return; }
  asking = true;
  try {
    now.status = await ask("status");
    now.health_taken = kLive ? Date.now() * 1e6 : now.status.taken_unix_ns;
    showHealth();
    const taken = kLive ? Date.now() * 1e6 : now.status.taken_unix_ns;
    const parts = await Promise.all([ask("channels"), ask("networks"), ask("routes"), ask("reservations"), ask("history", "--limit", pastAsked()), ask("audit", "report"),
      ...askCluster()]);
    now.channels = sorted(parts[0].channels);
    now.networks = parts[1].networks;
    now.routes = parts[2];
    now.reservations = parts[3].resources;
    now.history = parts[4].entries;
    now.audit = parts[5];
    now.cluster = parts[6];
    now.members = parts[7]?.members ?? null;
    now.taken_there = parts[8]?.reservations ?? now.taken_there;
    now.taken = taken;
    counters.of(now.channels, now.status.interfaces);
    settle();
    showHealth();
    showMap();
    for (const name of kLive ? [tab] : Object.keys(kTabs)) showTab(name);
    const open = now.channels.find((c) => key(c) === chosen);
    if (open && !by("detail").contains(document.activeElement.closest?.(".buttons, .wide") ?? null)) openChannel(open, true);
  } catch (problem) {
    now.status = null;
    showHealth(problem.message);
  }
  asking = false;
  document.body.dataset.ready = String(Number(document.body.dataset.ready ?? 0) + 1);
  // The answers for 1,000 channels have 4 MB. Counters and events come by other ways, so the rest is asked for less
  // often there.
  soon(again ? 300 : now.channels.length > 200 ? 30000 : 5000);
  again = false;
}
const kHealthEvery = [1000, 5000]; // least ms from one answer to the next question, up to 200 channels and above
const withoutTimes = (health) => JSON.stringify(health.reasons).replace(/\d+/g, "");
/**
 * The reasons state durations, so they are asked for as often as counters come, if there are any or a counter has
 * changed.
 */
async function refreshHealth(changed) {
  const every = kHealthEvery[Number(now.channels.length > 200)] * 1e6;
  if (asking || now.health_asked || Date.now() * 1e6 - now.health_taken < every || !(changed || now.status.health.reasons.length)) return;
  now.health_asked = true;
  try {
    const fresh = await ask("status");
    if (now.status && !asking) {
      const other = withoutTimes(fresh.health) !== withoutTimes(now.status.health);
      now.status = { ...fresh, interfaces: now.status.interfaces }; // these have the counters
      now.health_taken = Date.now() * 1e6;
      showHealth();
      if (other) soon(300);
    }
  } catch {
    soon(300); // which shows the problem
  }
  now.health_asked = false;
}
function soon(ms) {
  clearTimeout(due);
  if (!cockpit.hidden) due = setTimeout(refresh, ms);
}

function followCockpitStyle() {
  const style = (kLive && localStorage.getItem("shell:style")) || "auto";
  const dark = style === "dark" || (style === "auto" && matchMedia("(prefers-color-scheme: dark)").matches);
  document.documentElement.classList.toggle("pf-theme-dark", dark);
}

followCockpitStyle();
window.addEventListener("storage", followCockpitStyle);
window.addEventListener("cockpit-style", followCockpitStyle);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", followCockpitStyle);
makeTabs();
addEventListener("beforeprint", forPaper);
addEventListener("afterprint", () => list.all(!kLive));
document.addEventListener("keydown", (e) => { if (e.key === "Escape" && !by("detail").hidden && !by("dialog").open) closeDetail(); });
let width = 0;
new ResizeObserver(() => { if (by("map").clientWidth !== width) { width = by("map").clientWidth; if (now.status) showMap(); } }).observe(by("map"));
cockpit.addEventListener("visibilitychange", () => { if (!cockpit.hidden) refresh(); });
refresh();
followCounters((line) => {
  const known = counters.take(line);
  if (!now.taken || !now.status) return;
  now.taken = Date.now() * 1e6;
  if (known) showCounters();
  else soon(300);
  refreshHealth(line.counters.length > 0 || line.interfaces.length > 0);
}, () => counters.lost());
follow((event) => {
  if (kLoud.includes(event.kind)) say(event.message);
  soon(300);
}, (live) => {
  now.live = live;
  if (now.status) showHealth();
});
