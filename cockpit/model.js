// SPDX-License-Identifier: BSD-2-Clause
// Conclusions from the answers of mlccactl. Nothing here draws.
import { many } from "./format.js";
import { inWords } from "./place.js";

export const key = (c) => [c.subject, c.publisher, c.admission, c.from, c.to].join("\n");

/** The state of a delivery: the first of withdrawn, refused, silent, problem, degraded and granted that holds. */
export function stateOf(c) {
  if (c.withdrawn) return "withdrawn";
  if (!c.granted) return "refused";
  if (c.watch?.silent_ns) return "silent";
  if (c.problems.length) return "problem";
  return c.set > 0 ? "degraded" : "granted";
}
export const kStates = {
  refused: { mark: "✕", rank: 0, bad: true },
  silent: { mark: "!", rank: 1, bad: true },
  problem: { mark: "!", rank: 2, bad: true },
  withdrawn: { mark: "–", rank: 3 },
  degraded: { mark: "↓", rank: 4 },
  granted: { mark: "✓", rank: 5 },
};

const kReasons = 5; // most reasons of a banner

/**
 * The reasons for a banner, at most 5: those that differ only in names and numbers are one, with their number.
 * `leftOut` is the number of further reasons that mlccad has not listed.
 */
export function banner(reasons, leftOut = 0) {
  const kinds = new Map();
  for (const reason of reasons) {
    const kind = reason.replace(/^.*?: /, "").replace(/[\w.:]*\d[\w.:]*/g, "#");
    const known = kinds.get(kind);
    if (known) ++known.count;
    else kinds.set(kind, { reason, count: 1 });
  }
  const all = [...kinds.values()];
  const lines = all.slice(0, kReasons).map((k) => k.count === 1 ? k.reason : `${k.reason} (and ${many(k.count - 1, "reason")} like it)`);
  const more = all.slice(kReasons).reduce((sum, k) => sum + k.count, leftOut);
  return more ? [...lines, `and ${many(more, "further reason")}`] : lines;
}

/** The margin of the comparison that decided, in words. */
export const marginOf = (c) => c.margin?.words ?? "";

/**
 * The name of a finding: "stop of lever"; for frames of no delivery the described channel, the subject or the
 * identifier.
 */
export function findingName(f) {
  if (f.channel) return `${f.channel} of ${f.publisher}`;
  if (f.others) return "frames of other kinds";
  const own = f.subject ?? (f.identifier || "frames");
  return f.described ? `${f.described} (${own})` : own;
}

export function sorted(channels) {
  return channels.map((c) => ({ ...c, state: stateOf(c) })).sort((a, b) =>
    kStates[a.state].rank - kStates[b.state].rank || a.name.localeCompare(b.name) || a.to.localeCompare(b.to));
}

/** The largest reserved or used share of the resources of a network or gateway; null if it is not known. */
export function load(name, resources) {
  let most = null;
  for (const r of resources)
    if ((r.name === name || r.name.startsWith(`${name}: `)) && r.capacity)
      most = Math.max(most ?? 0, (r.reserved + r.background) / r.capacity);
  return most;
}

const kSettled = 1e9; // ns; the number of events between two closer answers means nothing

/**
 * How often the events of each publisher come: between the last two answers, or since the admission before there are
 * two.
 */
export class Counted {
  #taken = 0;
  #events = new Map();
  #share = new Map(); // by publisher, share of the rate that its Period allows

  take(channels, taken) {
    const seconds = (taken - this.#taken) / 1e9;
    if (taken - this.#taken < kSettled) return;
    const events = new Map();
    const share = new Map();
    for (const c of channels) {
      const w = c.watch;
      const name = `${c.name}\n${c.publisher}`;
      if (!c.granted || !w || w.shared || events.has(name)) continue; // another delivery of the same events
      const before = this.#events.get(name);
      const hertz = before !== undefined && before <= w.events ? (w.events - before) / seconds : (w.rate_millihertz ?? 0) / 1000;
      events.set(name, w.events);
      share.set(name, hertz * w.period_ns / 1e9);
    }
    this.#taken = taken;
    this.#events = events;
    this.#share = share;
  }
  /** The share of a publisher; undefined if its events are not counted. */
  share(channel, publisher) { return this.#share.get(`${channel}\n${publisher}`); }
}

/** The share of a resource that is used, the number of measured reservations and of all; null if none is measured. */
export function used(resource, counted) {
  let [amount, measured] = [0, 0];
  for (const r of resource.reservations) {
    const share = counted.share(r.channel, r.publisher);
    if (share === undefined) continue;
    amount += r.amount * share;
    measured += 1;
  }
  return measured && resource.capacity ? { part: amount / resource.capacity, measured, of: resource.reservations.length } : null;
}

/** Of the resources of a place, the one with the largest used share; null if none is known. */
function mostUsed(name, resources, counted) {
  const all = resources.filter((r) => r.name === name || r.name.startsWith(`${name}: `)).map((r) => used(r, counted)).filter(Boolean);
  return all.reduce((most, one) => !most || one.part > most.part ? one : most, null);
}

/**
 * The index of the last place of the route that the events reach. For a refused channel it is the place before the
 * first unfit hop. If no single hop is the reason, or the channel is withdrawn, it is the first place.
 */
export function lastHop(c) {
  if (c.granted) return c.route.length - 1;
  const unfit = c.route.findIndex((place) => c.rows.some((row) => row.outcome !== "fit" && row.where === place));
  return Math.max(0, unfit - 1);
}

/** The graph of the present places and connections, with the number of deliveries on each connection. */
export function graphOf({ status, networks, channels, reservations, routes, counted }) {
  const places = new Map();
  const place = (name, gateway) => {
    if (!places.has(name)) places.set(name, { name, gateway, next: new Set(), order: 0 });
    return places.get(name);
  };
  for (const n of networks) {
    const here = place(n.name, false);
    here.network = n;
    here.interfaces = status.interfaces.filter((i) => i.network === n.name);
    here.links = routes.links.filter((l) => l.network === n.name);
    here.load = load(n.name, reservations);
    here.used = mostUsed(n.name, reservations, counted);
    for (const g of n.gateways) {
      const gateway = place(g, true);
      gateway.next.add(n.name);
      here.next.add(g);
    }
  }
  for (const p of places.values()) {
    if (p.gateway) {
      p.own = p.name === status.gateway;
      p.load = load(p.name, reservations);
      p.used = mostUsed(p.name, reservations, counted);
    }
    Object.assign(p, inWords(p));
  }
  return joined(places, channels);
}

/**
 * Joins `places` (by name, each with the names of its neighbours in `next`). A channel with `many` stands for so many
 * with the same route.
 */
export function joined(places, channels) {
  const edges = new Map();
  const between = (p, q) => {
    const [a, b] = [p, q].sort();
    const name = `${a}\n${b}`;
    if (!edges.has(name)) edges.set(name, { a, b, granted: 0, open: 0, refused: 0 });
    return edges.get(name);
  };
  for (const c of channels) {
    const all = c.many ?? 1;
    const from = places.get(c.from);
    const to = places.get(c.to);
    if (from) from.order -= all;
    if (to) to.order += all;
    const end = lastHop(c);
    for (let i = 0; i + 1 < c.route.length; ++i) {
      const edge = between(c.route[i], c.route[i + 1]);
      if (c.granted) edge[c.open ? "open" : "granted"] += all;
      else if (i === end) edge.refused += all; // it ends at the place before this connection
    }
  }
  for (const p of places.values())
    for (const n of p.next) between(p.name, n);
  return { places, edges: [...edges.values()], columns: columnsOf(places) };
}

/**
 * Columns by breadth-first search, from the places from which most events come, so that events go from left to right.
 */
function columnsOf(places) {
  const columns = [];
  const seen = new Set();
  const rest = [...places.values()].sort((a, b) => a.order - b.order || (a.label ?? a.name).localeCompare(b.label ?? b.name));
  for (const root of rest) {
    let front = seen.has(root.name) ? [] : [root];
    for (let column = 0; front.length; ++column) {
      for (const p of front) seen.add(p.name);
      (columns[column] ??= []).push(...front);
      front = [...new Set(front.flatMap((p) => [...p.next]))].filter((n) => !seen.has(n))
        .map((n) => places.get(n));
    }
  }
  return columns;
}
