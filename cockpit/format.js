// SPDX-License-Identifier: BSD-2-Clause
// Formats numbers for people.

const shortened = (value) => value.toLocaleString("en", { maximumSignificantDigits: 3 });

function scaled(value, steps) {
  for (const [size, unit] of steps) if (value >= size) return `${shortened(value / size)} ${unit}`;
  return `${shortened(value)} ${steps.at(-1)[1]}`;
}

export function duration(ns) {
  if (ns === null || ns === undefined) return "";
  if (ns === "unbounded") return "for ever";
  return scaled(ns, [[86400e9, "d"], [3600e9, "h"], [60e9, "min"],
    [1e9, "s"], [1e6, "ms"], [1e3, "µs"], [1, "ns"]]);
}
const kSecond = 1e9;
const kParts = [["d", 86400], ["h", 3600], ["min", 60], ["s", 1]];

/** A past time: "104 ms", "11 s", "1 min 23 s", "2 h 5 min". */
export function elapsed(ns) {
  const seconds = Math.floor(ns / kSecond);
  if (seconds < 1) return duration(ns);
  const first = kParts.findIndex(([, size]) => seconds >= size);
  const [unit, size] = kParts[first];
  const [less, part] = kParts[first + 1] ?? ["", 1];
  const rest = Math.floor((seconds % size) / part);
  return `${Math.floor(seconds / size)} ${unit}${less && rest ? ` ${rest} ${less}` : ""}`;
}

const kUnits = { s: 1, min: 60, h: 3600, d: 86400 };
const kSilence = /(nothing has come for|nothing has come since the gate lets it in,|the latest) (\d+(?:\.\d+)?) (s|min|h|d)(?![a-z/])/g;
/** A line of mlccad's health, with the times in it formatted for people. */
export const forPeople = (line) => line.replace(kSilence, (_, words, number, unit) => `${words} ${elapsed(number * kUnits[unit] * kSecond)}`);

export const rate = (bytes) => scaled(bytes, [[1e9, "GB/s"], [1e6, "MB/s"], [1e3, "kB/s"], [1, "B/s"]]);
export const bits = (bit) => scaled(bit, [[1e9, "Gbit/s"], [1e6, "Mbit/s"], [1e3, "kbit/s"], [1, "bit/s"]]);
export const percent = (part) => `${shortened(part * 100)} %`;
export const count = (n) => (n ?? 0).toLocaleString("en");
export const many = (n, one, more = `${one}s`) => `${count(n)} ${n === 1 ? one : more}`;
/// The number of passed frames. It is not known if the events cross no gate of this gateway.
export const passed = (c) => (c.crosses_no_gate ? "-" : count(c.passed));
export const moment = (unixNs) => new Date(unixNs / 1e6).toLocaleString("sv");

export function value(number, unit) {
  if (number === null || number === undefined) return "nothing";
  if (number === "unbounded") return "unbounded";
  if (unit === "ns") return duration(number);
  if (unit === "bytes/s") return rate(number);
  if (unit === "1e-9") return percent(number / 1e9);
  const own = /^1e(-?\d+)(?: (.*))?$/.exec(unit);  // an attribute that the description defines
  if (own) {
    const places = Math.min(Math.max(-Number(own[1]), 0), 20);
    const text = (number * 10 ** Number(own[1])).toLocaleString("en", { maximumFractionDigits: places });
    return own[2] ? `${text} ${own[2]}` : text;
  }
  return `${count(number)}${unit === "events" || unit === "" ? "" : ` ${unit}`}`;
}
