// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/health.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "base/many.hpp"
#include "control/watches.hpp"
#include "core/model/text.hpp"
#include "daemon/gateway/drops.hpp"

namespace mlcca {
namespace {

/// The time that a publisher which has just started may need until its first event.
constexpr std::uint64_t kFirstEvent = 1'000'000'000;  // ns
constexpr std::uint64_t kFirstPeriods = 3;
/// Events that may be between the two gates.
constexpr std::uint64_t kOnTheirWay = 1;

/// The time rounded down to a millisecond.
std::string time(std::uint64_t ns) {
  return core::format_value(Attribute::latency, ns - ns % 1'000'000);
}

/// "18 frames on lan in the last 42 s". Longer times are given in minutes.
std::string recent_frames(const RecentDrops& recent, const std::string& network) {
  const auto seconds = std::max<std::int64_t>(recent.seconds, 1);
  return fmt::format(
      "{} on {} in the last {}", many(recent.frames, "frame"), network,
      seconds < 120 ? fmt::format("{} s", seconds) : fmt::format("{} min", (seconds + 59) / 60));
}

/// Adds the frames without a slot: they may be those of the publisher under another identifier.
void add_unknown(const Observed& seen, std::vector<std::string>& lines) {
  const auto in = std::ranges::find(seen.passages, false, &Passage::leaves);
  if (in == seen.passages.end() || seen.unknown.frames == 0) return;
  lines.push_back(fmt::format(
      "{} named no known subject, the latest {}: does the publisher send by another name?",
      recent_frames(seen.unknown, in->network), seen.latest_unknown));
}

/// Whether events are overdue where no subscriber states a timeout.
bool is_late(const control::Watch& watch) {
  const std::uint64_t periods = std::max<std::uint64_t>(watch.period_ns, 1) * kFirstPeriods;
  return watch.since_last_ns > std::max(kFirstEvent, periods);
}

void add_silence(const control::Watch& watch, std::vector<std::string>& lines) {
  const std::uint64_t period = std::max<std::uint64_t>(watch.period_ns, 1);
  const std::uint64_t silent = silent_for(watch);
  if (is_coming_again(watch)) {
    lines.push_back(fmt::format("events come again, the latest {} ago: not restored yet",
                                time(watch.since_last_ns)));
  } else if (silent != 0 && watch.events == 0) {
    lines.push_back(fmt::format(
        "no publisher sends: nothing has come since the gate lets it in, {} ago", time(silent)));
  } else if (silent != 0 && watch.missing_now) {
    lines.push_back(fmt::format("nothing has come for {}: {} missing", time(silent),
                                many(silent / period, "event is", "events are")));
  } else if (silent != 0) {
    lines.push_back(fmt::format("nothing has come for {}, and the publisher sends every {}",
                                time(silent), time(watch.period_ns)));
  }
}

std::string misfit_line(const Passage& at, const RecentDrops& misfits) {
  std::string line = fmt::format("{} named the subject and differed from the grant",
                                 recent_frames(misfits, at.network));
  if (!at.frames.last_reason) return line;
  return line.append(misfits.frames == 1 ? ": " : ", the latest: ")
      .append(core::to_text(*at.frames.last_reason));
}

std::string excess_line(const Passage& at, const RecentDrops& excess) {
  return fmt::format("{} {} more than was admitted", recent_frames(excess, at.network),
                     excess.frames == 1 ? "was" : "were");
}

/// Says that frames passed in audit mode; the mode may have changed since.
constexpr std::string_view kInAuditMode = " (passed in audit mode)";

void add_drops(const Passage& at, std::vector<std::string>& lines) {
  if (at.excess.frames != 0) lines.push_back(excess_line(at, at.excess));
  if (at.would_exceed.frames != 0)
    lines.push_back(excess_line(at, at.would_exceed).append(kInAuditMode));
  if (at.misfits.frames != 0) lines.push_back(misfit_line(at, at.misfits));
  if (at.would_be_misfits.frames != 0)
    lines.push_back(misfit_line(at, at.would_be_misfits).append(kInAuditMode));
}

/// Adds that a granted delivery forwards nothing although its events come.
void add_lost(const Observed& seen, std::vector<std::string>& lines) {
  const auto in = std::ranges::find_if(seen.passages,
                                       [](const Passage& p) { return !p.leaves && !p.is_shared; });
  if (in == seen.passages.end()) return;
  for (const Passage& out : seen.passages) {
    if (!out.leaves) continue;
    const bool none = out.frames.passed == 0;
    if (!none && (!out.latest || out.latest->out != out.frames.passed)) continue;
    // Frames that came before may have left by slots that do not exist any more.
    const std::uint64_t before = std::max(in->passed_before, none ? 0 : out.latest->in);
    const std::uint64_t came = in->frames.passed - std::min(before, in->frames.passed);
    if (came <= kOnTheirWay * in->event_frames) continue;
    lines.push_back(fmt::format(
        "{} came in from {} {} left to {}{}", many(came, "frame"), in->network,
        none ? "and none" : "since the latest", out.network,
        out.misfits.frames + out.would_be_misfits.frames == 0 ? ": nothing forwards them" : ""));
  }
}

}  // namespace

std::uint64_t silent_for(const control::Watch& watch) {
  const bool nobody_waits = watch.events == 0 || watch.timeout_ns == 0;
  if (is_coming_again(watch) || !(watch.missing_now || (nobody_waits && is_late(watch)))) return 0;
  return std::max<std::uint64_t>(watch.since_last_ns, 1);
}

std::vector<std::string> troubles(const Observed& seen) {
  std::vector<std::string> lines;
  if (seen.watch) add_silence(*seen.watch, lines);
  if (!lines.empty()) add_unknown(seen, lines);
  if (!seen.not_supervised.empty()) lines.push_back("not supervised: " + seen.not_supervised);
  for (const Passage& at : seen.passages) add_drops(at, lines);
  if (!seen.not_forwarded.empty())
    lines.push_back(seen.not_forwarded);
  else
    add_lost(seen, lines);
  if (!seen.late.empty()) lines.push_back(seen.late);
  return lines;
}

std::string unlisted_gates(std::string_view why) {
  return fmt::format(
      "mlccad cannot list the gates of the kernel ({}): a gate without pins may be left on an "
      "interface that is not described",
      why.contains("BTF") ? "its BTF cannot be read" : "the system log says why");
}

control::Health health_of(bool open, std::vector<std::string> lines) {
  control::Health out;
  out.state = lines.empty() ? control::HealthState::healthy : control::HealthState::degraded;
  if (!open) out.state = control::HealthState::closed;
  if (lines.size() > control::Health::kMostReasons) {
    out.left_out = static_cast<std::uint32_t>(lines.size() - control::Health::kMostReasons);
    lines.resize(control::Health::kMostReasons);
  }
  out.reasons = std::move(lines);
  return out;
}

}  // namespace mlcca
