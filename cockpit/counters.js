// SPDX-License-Identifier: BSD-2-Clause
// Keeps the counters of the latest answers up to date with the lines of `mlccactl --json top`.
import { key } from "./model.js";

export class Counters {
  #keys = []; // keys of the deliveries, in the order in which lines number them
  #latest = new Map(); // the latest counters of each delivery, by key
  #traffic = new Map(); // the latest counters of each interface, by name
  #channels = new Map();
  #interfaces = new Map();
  #at = 0; // time of the ages in the answers, ms

  /** Takes new answers, which may be older than the latest line. */
  of(channels, interfaces) {
    this.#channels = new Map(channels.map((c) => [key(c), c]));
    this.#interfaces = new Map(interfaces.map((i) => [i.name, i]));
    this.#at = performance.now();
    for (const name of this.#latest.keys()) this.#put(name);
    for (const [name, traffic] of this.#traffic) Object.assign(this.#interfaces.get(name) ?? {}, traffic);
  }
  /** Takes one line. False if it begins to number deliveries of which some are in no answer. */
  take(line) {
    const passed = (performance.now() - this.#at) * 1e6;
    this.#at = performance.now();
    for (const { watch } of this.#channels.values())
      if (watch) {
        watch.since_last_ns += passed;
        if (watch.silent_ns) watch.silent_ns += passed;
      }
    if (line.deliveries) {
      this.#keys = line.deliveries.map(key);
      this.#latest.clear();
    }
    for (const { delivery, ...counted } of line.counters) {
      this.#latest.set(this.#keys[delivery], counted);
      this.#put(this.#keys[delivery]);
    }
    for (const { name, ...traffic } of line.interfaces) {
      this.#traffic.set(name, traffic);
      Object.assign(this.#interfaces.get(name) ?? {}, traffic);
    }
    return !line.deliveries || this.#keys.every((name) => this.#channels.has(name));
  }
  /** No more lines come, so the counters of later answers are used as they are. */
  lost() {
    this.#latest.clear();
    this.#traffic.clear();
  }
  #put(name) {
    const channel = this.#channels.get(name);
    if (!channel) return;
    const { watch, ...frames } = this.#latest.get(name);
    Object.assign(channel, frames);
    if (channel.watch && watch) Object.assign(channel.watch, watch);
  }
}
