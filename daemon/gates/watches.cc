// SPDX-License-Identifier: BSD-2-Clause
// The kernel writes meanwhile, so each number is read once, in one load.
#include "daemon/gates/watches.hpp"

#include <cmath>
#include <cstddef>

#include "base/clock.hpp"
#include "daemon/gates/publish.hpp"

namespace mlcca::gates {
namespace {

std::uint64_t load(const __u64& word) { return __atomic_load_n(&word, __ATOMIC_RELAXED); }

std::uint64_t per_1000_seconds(std::uint64_t events, std::uint64_t ns) {
  return static_cast<std::uint64_t>(
      std::llround(static_cast<double>(events) * 1e12 / static_cast<double>(ns)));
}

}  // namespace

void forget_findings(gate_watch& watch) {
  for (__u64* word : {&watch.last, &watch.last_gap, &watch.shortest, &watch.longest,
                      &watch.deviation, &watch.missing, &watch.silent, &watch.first})
    publish(*word, __u64{0});
  publish(watch.since, __u64{monotonic_ns()});
  for (__u64& gaps : watch.gaps) publish(gaps, __u64{0});
}

/// With a period of 0 no frame writes to the watch while it is changed.
void expect_events(gate_watch& watch, const SlotSpec& spec) {
  if (watch.period != spec.period) {
    publish(watch.period, __u64{0});
    forget_findings(watch);
  }
  publish(watch.scale, gate_gap_scale(spec.period));
  publish(watch.together, __u64{spec.together});
  publish(watch.silence, __u64{spec.silence});
  publish(watch.period, __u64{spec.period});
}

Arrivals arrivals(const gate_watch& watch, std::uint64_t now) {
  Arrivals out;
  const std::uint64_t period = load(watch.period);
  const std::uint64_t last = load(watch.last);
  const std::uint64_t begin = last != 0 ? last : load(watch.since);
  for (std::size_t i = 0; i < GATE_GAPS; ++i) {
    out.gaps[i] = load(watch.gaps[i]);
    out.events += out.gaps[i];
  }
  if (last != 0) ++out.events;
  out.since_last = begin != 0 && now > begin ? now - begin : 0;
  const std::uint64_t first = load(watch.first);
  if (out.events > 1 && last > first) out.rate = per_1000_seconds(out.events - 1, last - first);
  out.silence = load(watch.silence);
  out.silent = load(watch.silent) != 0 && out.silence != 0;
  out.missing = load(watch.missing);
  // As between two events, half a period late counts as missing. After the timeout the time itself
  // decides, because nothing can be late any more.
  if (last != 0 && period != 0 && out.since_last > period)
    out.missing +=
        out.silent ? out.since_last / period : (out.since_last + period / 2) / period - 1;
  out.last_gap = load(watch.last_gap);
  out.shortest = load(watch.shortest);
  out.longest = load(watch.longest);
  out.jitter = load(watch.deviation);
  return out;
}

}  // namespace mlcca::gates
