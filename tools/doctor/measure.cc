// SPDX-License-Identifier: BSD-2-Clause
#include "tools/doctor/measure.hpp"

#include <algorithm>
#include <cstdint>

#include "base/clock.hpp"

namespace mlcca::doctor {
namespace {

/// How long a second echo of a frame is waited for, in ms.
constexpr unsigned kSecondEchoMs = 100;
constexpr unsigned kFewest = 20;
constexpr unsigned kMost = 5000;
/// So many of our frames are under way at a time, so that the controller always has the next one.
constexpr unsigned kUnderWay = 8;

/// Reads and drops frames, so that echoes of one measurement do not appear in the next.
Result<void> discard(const Probe& probe) {
  for (;;) {
    const auto seen = probe.next(0);
    if (!seen) return std::unexpected(seen.error());
    if (!*seen) return {};
  }
}

/// Whether collect() ends with the echo of the last frame, or always after the full time.
enum class Until : std::uint8_t { the_last_one, the_end };
Result<void> collect(const Probe& probe, std::vector<Single>& singles, unsigned patience_ms,
                     Until until) {
  const auto end = monotonic_ns() + std::uint64_t{patience_ms} * 1'000'000;
  for (auto now = monotonic_ns(); now < end; now = monotonic_ns()) {
    const auto seen = probe.next(static_cast<unsigned>((end - now) / 1'000'000) + 1);
    if (!seen) return std::unexpected(seen.error());
    if (!*seen || !(*seen)->own || (*seen)->number >= singles.size()) continue;
    singles[(*seen)->number].echoes_ns.push_back((*seen)->ns);
    if (until == Until::the_last_one && !singles.back().echoes_ns.empty()) break;
  }
  return {};
}

}  // namespace

Result<std::vector<Single>> send_singly(const Probe& probe, unsigned count) {
  std::vector<Single> singles;
  if (auto done = discard(probe); !done) return std::unexpected(done.error());
  for (unsigned i = 0; i < count; ++i) {
    singles.push_back({.sent_ns = unix_ns(),
                       .length = core::can::wire_length(probe.frame(i, false)),
                       .echoes_ns = {}});
    const auto sent = probe.send(i, false);
    if (!sent) return std::unexpected(sent.error());
    singles.back().refused = !*sent;
    if (!*sent) return singles;
    auto came = collect(probe, singles, kPatienceMs, Until::the_last_one);
    if (!came) return std::unexpected(came.error());
    if (singles.back().echoes_ns.empty()) return singles;
  }
  if (auto more = collect(probe, singles, kSecondEchoMs, Until::the_end); !more)
    return std::unexpected(more.error());
  return singles;
}

unsigned frames_for_passage(const Probe& probe, const core::can::Timing& timing, bool fd) {
  const auto one = core::can::wire_time(timing, core::can::wire_length(probe.frame(0, fd)));
  return static_cast<unsigned>(
      std::clamp<core::can::Time>(kPassageNs / std::max<core::can::Time>(one, 1), kFewest, kMost));
}

Result<Passage> send_back_to_back(const Probe& probe, unsigned count, bool fd) {
  PassageCount counted;
  const Passage& passage = counted.passage();
  if (auto done = discard(probe); !done) return std::unexpected(done.error());
  auto last_own = monotonic_ns();
  while (passage.echoed < count) {
    while (passage.sent < count && passage.sent - passage.echoed < kUnderWay) {
      const auto sent = probe.send(passage.sent, fd);
      if (!sent) return std::unexpected(sent.error());
      if (!*sent) break;
      counted.take_sent();
    }
    const auto seen = probe.next(kPatienceMs);
    if (!seen) return std::unexpected(seen.error());
    if (*seen) counted.take_seen(**seen);
    if (*seen && (*seen)->own) last_own = monotonic_ns();
    if (monotonic_ns() - last_own > std::uint64_t{kPatienceMs} * 1'000'000) break;
  }
  return passage;
}

Result<Filling> fill(const Probe& probe, unsigned limit) {
  Filling filling;
  if (auto done = discard(probe); !done) return std::unexpected(done.error());
  while (filling.taken < limit + kMostBehind && !filling.refused) {
    const auto sent = probe.send(filling.taken, false);
    if (!sent) return std::unexpected(sent.error());
    filling.refused = !*sent;
    if (*sent) ++filling.taken;
  }
  const auto refused_ns = unix_ns();
  auto last_own = monotonic_ns();
  while (filling.echoed < filling.taken &&
         monotonic_ns() - last_own <= std::uint64_t{kPatienceMs} * 1'000'000) {
    const auto seen = probe.next(kPatienceMs);
    if (!seen) return std::unexpected(seen.error());
    if (!*seen || !(*seen)->own) continue;
    last_own = monotonic_ns();
    ++filling.echoed;
    if ((*seen)->ns <= refused_ns) ++filling.left;
  }
  return filling;
}

}  // namespace mlcca::doctor
