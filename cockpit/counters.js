// SPDX-License-Identifier: BSD-2-Clause
// Counters between two answers: what has changed of them is put into what is there.
import { key } from "./model.js";

export class Counters {
  #keys = []; // of the deliveries, in the order in which lines name them
  #latest = new Map(); // what lines have said of each, by key
  #traffic = new Map(); // the same of interfaces
  #channels = new Map();
  #interfaces = new Map();
  #at = 0; // when that was so, ms

  /** Answers, which may be older than the latest line. */
  of(channels, interfaces) {
    this.#channels = new Map(channels.map((c) => [key(c), c]));
    this.#interfaces = new Map(interfaces.map((i) => [i.name, i]));
    this.#at = performance.now();
    for (const name of this.#latest.keys()) this.#put(name);
    for (const [name, traffic] of this.#traffic) Object.assign(this.#interfaces.get(name) ?? {}, traffic);
  }
  /** One line of `mlccactl --json top`. False: it begins to name deliveries that no answer has had. */
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
  /** No more lines come: what answers say holds. */
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
