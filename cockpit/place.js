// SPDX-License-Identifier: BSD-2-Clause
// The texts of a place in the drawing: its kind and its state.
import { bits, many, rate } from "./format.js";

/**
 * The kind and the rate of a network: "can, 500 kbit/s". Without a `bitrate` of an interface: the `described` one in
 * bit/s, the `slowest` of the `links` of a mesh in bit/s, or the `capacity` in bytes/s.
 */
export function carries(kind, { bitrate, described, links, slowest, capacity, unknown = "no rate stated" }) {
  return `${kind}, ${bitrate ? bits(bitrate)
    : described ? `${bits(described)}, described`
      : links ? `${many(links, "link")}, ${bits(slowest)} or more`
        : capacity ? rate(capacity) : unknown}`;
}

function condition(p) {
  if (!p.network.available) return p.network.problem || "not available";
  return p.interfaces.map((i) => {
    if (!i.ifindex) return `${i.name} is absent`;
    if (i.problem) return i.problem.startsWith(i.name) ? i.problem : `${i.name}: ${i.problem}`;
    if (!i.up) return `${i.name} is down`;
    return `${i.name}${i.profile === "none" && !i.attached ? ", no gate" : i.attached ? ", gated" : ", NO GATE"}`;
  }).join("; ");
}

/** `subtitle` and `note` are lines of the box of a place. `ill`: the place needs attention. */
export function inWords(p) {
  if (p.gateway) return { subtitle: p.own ? "this gateway" : "gateway", note: "", ill: false };
  const rates = p.links.map((l) => l.believed_rate).filter((r) => r > 0);
  return {
    subtitle: carries(p.network.kind, {
      bitrate: p.interfaces.find((i) => i.bitrate)?.bitrate, described: p.network.described_bitrate,
      capacity: p.network.capacity, links: rates.length, slowest: Math.min(...rates),
      unknown: p.network.kind === "can" ? "rate not known" : undefined,
    }),
    note: condition(p),
    ill: !p.network.available || p.interfaces.some((i) => !i.ifindex || !i.up || i.problem || (!i.attached && i.profile !== "none")),
  };
}
