// SPDX-License-Identifier: BSD-2-Clause
// The gateways that share networks in a cluster, as `mlccactl cluster` reports them.
import { table } from "./detail.js";
import { h } from "./dom.js";
import { count, duration, elapsed, many, rate } from "./format.js";

const kShownReservations = 200;
const kDigits = 12; // characters of a digest that are shown
const kWell = ["active", "granted"];

const cells = (...all) => h("tr", {}, all.map((c) => h("td", {}, c)));
const stateWord = (text, good) => h("span", { class: `verdict ${good ? "granted" : "degraded"}` }, h("span", { "aria-hidden": "true" }, good ? "✓" : "!"), ` ${text}`);
const standingFact = (name, text, well) => [h("dt", {}, name), h("dd", { class: well ? "" : "bad" }, text)];

const kMayBeUsed = { open: "open", described: "what is reserved is closed", closed: "closed" };

function standing(cluster) {
  const same = cluster.digest && cluster.digest === cluster.own_digest;
  return [h("h3", {}, `${cluster.gateway} in the cluster ${cluster.system}`),
    h("dl", { class: "facts" },
      standingFact("phase", cluster.phase, cluster.phase === "in"),
      standingFact("shared networks", kMayBeUsed[cluster.shared] ?? cluster.shared, cluster.shared === "open"),
      standingFact("reserved lasts", cluster.lasts_ns ? `${duration(cluster.lasts_ns)} surely` : "no more", cluster.lasts_ns > 0),
      standingFact("description", cluster.generation ? `generation ${count(cluster.generation)}${same ? "" : ": another one"}` : "none in force", same),
      standingFact("store", `${cluster.store_up ? "answers" : "does not answer"} for ${duration(cluster.store_for_ns)}`, cluster.store_up)),
    h("ul", {}, cluster.health.reasons.map((reason) => h("li", { class: "problem" }, reason))),
    h("p", { class: "quiet" }, `Networks of several gateways: ${cluster.networks.join(", ") || "none"}`)];
}
function gatewayTable(members) {
  return table("Gateways", ["State", "Gateway", "Beat age", "Lasts", "Description", "Reserved", "Carries"], members.map((m) => cells(
    stateWord(m.state, kWell.includes(m.state)), m.own ? `${m.name} (this one)` : m.name, m.beats ? elapsed(m.beat_age_ns) : "",
    m.lasts_ns ? duration(m.lasts_ns) : "", m.digest ? `${m.digest.slice(0, kDigits)}${m.other ? ": another one" : ""}` : "",
    m.shares.map((s) => `${s.network}: ${count(s.reservations)}`).join(", "),
    `${m.carries.join(", ")}${m.carries_left_out ? ` and ${count(m.carries_left_out)} more` : ""}`)));
}
const amountWords = (r) => [r.bytes_per_second ? rate(r.bytes_per_second) : null, r.messages ? many(r.messages, "message") : null,
  r.paths ? many(r.paths, "path") : null].filter(Boolean).join(", ");
function takenParts(reservations) {
  if (!reservations) return [h("p", { class: "quiet" }, "What is reserved is asked.")];
  if (!reservations.length) return [h("p", { class: "quiet" }, "Nothing is reserved.")];
  return [table("Reservations", ["State", "Channel", "Network", "Gateway", "Publisher", "Amount", "Through"], reservations.slice(0, kShownReservations)
    .map((r) => cells(stateWord(r.state, kWell.includes(r.state)), r.channel, r.network, r.gateway, r.publisher, amountWords(r), r.through.join(", ")))),
  reservations.length > kShownReservations ? h("p", { class: "quiet" },
    `and ${count(reservations.length - kShownReservations)} more: mlccactl cluster reservations has all`) : null];
}

/** `cluster`: the state of this gateway; null if it is not known. */
export function clusterParts(cluster, members, reservations) {
  if (!cluster) return [h("p", { class: "quiet" }, "This mlccad does not say whether it takes part in a cluster.")];
  if (!cluster.system)
    return [h("p", { class: "quiet" }, `${cluster.gateway} takes part in no cluster: it decides alone about networks that it shares.`)];
  return [...standing(cluster), gatewayTable(members ?? []), ...takenParts(reservations)].filter((part) => part !== null);
}
