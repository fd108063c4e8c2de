// SPDX-License-Identifier: BSD-2-Clause
// The details of a decision, as `mlccactl explain` reports it, and of a network or gateway.
import { h } from "./dom.js";
import { bits, count, duration, elapsed, forPeople, many, moment, percent, rate, value } from "./format.js";
import { kStates, marginOf } from "./model.js";

const fact = (name, text) => (text === "" || text === null || text === undefined ? [] : [h("dt", {}, name), h("dd", {}, text)]);
export const table = (caption, names, rows) => h("div", { class: "wide", tabindex: 0, role: "region", "aria-label": caption },
  h("table", { "data-names": names[2] === "Required" && "true" }, h("caption", {}, caption), h("thead", {}, h("tr", {}, names.map((n) => h("th", { scope: "col" }, n)))),
    h("tbody", {}, rows)));

export const verdict = (state) => h("span", { class: `verdict ${state}` },
  h("span", { "aria-hidden": "true" }, kStates[state].mark), ` ${state}`);

export function silence(c) {
  if (!c.watch) return "";
  const { watch } = c;
  if (watch.silent_ns) return `nothing for ${elapsed(watch.silent_ns)}`;
  return watch.events ? `latest ${elapsed(watch.since_last_ns)} ago, ${c.sporadic ? "at most " : ""}every ${duration(watch.period_ns)}` : "none yet";
}

function story(c) {
  const rows = c.rows.map((row) => h("tr", { class: row.outcome },
    h("td", {}, row.where), h("td", {}, row.attribute), h("td", {}, value(row.required, row.unit)),
    h("td", {}, value(row.provided, row.unit)), h("td", {}, `${row.outcome === "fit" ? "✓" : "✕"} ${row.margin}`)));
  return table("Attribute by attribute", ["Where", "Attribute", "Required", "Provided", "Margin"], rows);
}

export const asOf = (taken) => h("p", { class: "quiet", id: "as-of" }, `as of ${moment(taken)}`);

export function channelFacts(c) {
  const w = c.watch;
  return h("dl", { class: "facts" },
    fact("Subject", c.subject), fact("Publisher", c.publisher), fact("Subscribers", c.subscribers.join(", ")),
    fact("Arrival", c.sporadic ? "sporadic: events come when something happens, and silence means nothing" : ""),
    fact("Reaction to silence", c.reaction), fact("Not supervised", c.not_supervised),
    fact("Margin", marginOf(c)), fact("Attribute set", c.sets > 1 ? `${c.granted ? c.set + 1 : "none"} of ${c.sets}` : ""),
    c.media.map((m) => fact(`On ${m.network}`, [
      m.response_ns ? `response ${duration(m.response_ns)}, at most ${duration(m.guaranteed_ns)}` : "",
      m.path.length ? `path ${m.path.join(" › ")}` : "", m.available ? `${rate(m.available)} left` : ""].filter(Boolean).join("; "))),
    fact("Frames", c.crosses_no_gate ? "not counted: they cross no gate of this gateway" :
      `${count(c.passed)} passed, ${count(c.dropped)} dropped, ${count(c.excess)} in excess`),
    fact("Would drop", c.would_drop ? `${count(c.would_drop)} that passed in audit mode` : ""),
    fact("Events", w ? `${count(w.events)} came, ${count(w.missing)} did not; ${silence(c)}` : ""),
    fact("Jitter", w && w.last_gap_ns && !w.shared ? duration(w.jitter_ns) : ""),
    fact("Admission", c.admission ? `number ${c.admission}, at run time` : "described"));
}

export function channelDetail(c, actions, taken) {
  return [
    h("p", { class: "lead" }, verdict(c.state), h("br"), c.reason),
    ...c.problems.map((t) => h("p", { class: "problem" }, forPeople(t))),
    asOf(taken),
    c.description ? h("p", {}, c.description) : null,
    h("ol", { class: "hops", "aria-label": "Route" }, c.route.map((place) => h("li", {}, place))),
    story(c),
    channelFacts(c),
    h("div", { class: "buttons" }, actions),
  ];
}

export function placeFacts(p, resources) {
  const own = resources.filter((r) => r.name === p.name || r.name.startsWith(`${p.name}: `));
  const held = own.map((r) => fact(r.name, r.capacity ? `${percent(r.reserved / r.capacity)} reserved${
    r.background ? `, ${percent(r.background / r.capacity)} by others` : ""}, by ${many(r.reservations.length, "publisher")}` : "no capacity is stated"));
  if (p.gateway) return h("dl", { class: "facts" }, fact("Kind", p.own ? "this gateway" : "gateway"), held);
  const { network } = p;
  const { described_bitrate: stated, described_data_bitrate: data } = network;
  return h("dl", { class: "facts" }, fact("Kind", network.kind), fact("Profile", network.profile),
    fact("Described", stated ? `${bits(stated)}${data ? `, data phase ${bits(data)}` : ""}` : ""),
    network.provision.map((a) => fact(a.name, `${value(a.value, a.unit)}${a.dynamic ? ", at best" : ""}`)), held,
    p.interfaces.map((i) => [
      fact(i.name, [i.ifindex ? (i.up ? "up" : "down") : "absent", i.can_state, i.bitrate ? bits(i.bitrate) : "",
        i.profile === "none" ? (i.attached ? "CLOSED: no profile" : "no gate by design") : i.attached ? `gate on ${i.hook}, ${many(i.slots, "slot")}` : "NO GATE",
        i.problem, i.drift].filter(Boolean).join(", ")),
      ["ingress", "egress"].map((way) => fact(way === "ingress" ? "Came in" : "Went out",
        `${count(i[way].passed)} passed, ${count(i[way].dropped)} dropped${i[way].would_drop ? `, ${count(i[way].would_drop)} would have been dropped` : ""}${Object.entries(i[way].reasons).filter(([why]) => why !== "passed")
          .map(([why, n]) => `; ${why}: ${count(n)}`).join("")}`))]));
}

export function placeDetail(p, resources) {
  if (p.gateway) return [placeFacts(p, resources)];
  return [
    p.network.problem ? h("p", { class: "problem" }, p.network.problem) : null,
    placeFacts(p, resources),
    p.links.length ? table("Links", ["From", "To", "Rate", "Loss", "State"], p.links.map((l) => h("tr", {},
      h("td", {}, l.from), h("td", {}, l.to), h("td", {}, l.believed_rate ? bits(l.believed_rate) : "0"),
      h("td", {}, l.loss === null ? "unknown" : percent(l.loss / 1e9)), h("td", {}, l.state || "carries")))) : null,
  ];
}
