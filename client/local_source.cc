// SPDX-License-Identifier: BSD-2-Clause
#include "client/local_source.hpp"

#include <algorithm>
#include <string>

#include "base/many.hpp"

namespace mlcca::client {
namespace {

/// An event that is older than its predecessor by more than this (ns) means that the system clock
/// was set back.
constexpr std::uint64_t kSetBack = 100'000'000;

std::string time_text(std::uint64_t ns) {
  constexpr std::uint64_t micro = 1'000;
  constexpr std::uint64_t milli = 1'000'000;
  return ns < 10 * milli ? std::to_string(ns / micro) + " us" : std::to_string(ns / milli) + " ms";
}

std::string events_text(std::uint64_t number) { return many(number, "event is", "events are"); }

}  // namespace

/// Policing by the generic cell rate algorithm, as in bpf/police.bpf.h.
bool LocalSource::is_in_turn(std::size_t bytes, std::uint64_t unix_ns) {
  constexpr unsigned fraction = 8;
  const std::uint64_t cost =
      granted_.event_cost_ns + (std::max<std::uint64_t>(bytes, 1) * granted_.byte_cost >> fraction);
  if (cost == 0) return true;
  if (unix_ns + kSetBack < seen_) turn_ = 0;
  seen_ = unix_ns;
  const std::uint64_t turn = std::max(turn_, unix_ns);
  if (turn - unix_ns > granted_.tolerance_ns) return false;
  turn_ = turn + cost;
  return true;
}

bool LocalSource::takes(std::size_t bytes, std::uint64_t unix_ns, std::uint64_t now) {
  if (granted_.frame_bytes != 0 && bytes > granted_.frame_bytes) return false;
  if (!is_in_turn(bytes, unix_ns)) {
    if (excess_++ == 0) excess_at_ = now;
    return false;
  }
  if (silent_at_ != 0 && (back_at_ == 0 || now - last_ >= granted_.silence_ns)) back_at_ = now;
  last_ = now;
  return true;
}

void LocalSource::miss(std::uint64_t events, std::uint64_t now) {
  if (events == 0) return;
  if (missed_ == 0) missed_at_ = now;
  missed_ += events;
}

std::optional<std::uint64_t> LocalSource::due() const {
  std::optional<std::uint64_t> excess;
  if (excess_ != 0) excess = excess_at_ + kPause;
  std::optional<std::uint64_t> missed;
  if (missed_ != 0) missed = missed_at_ + kPause;
  std::optional<std::uint64_t> turned;
  if (silent_at_ != 0) {
    if (back_at_ != 0) turned = back_at_ + kHold;
  } else if (granted_.silence_ns != 0) {
    turned = last_ + granted_.silence_ns;
  }
  std::optional<std::uint64_t> first;
  for (const auto& one : {excess, missed, turned})
    if (one && (!first || *one < *first)) first = one;
  return first;
}

std::optional<control::Event> LocalSource::happened(std::uint64_t now) {
  if (excess_ != 0 && now >= excess_at_ + kPause) return excess();
  if (missed_ != 0 && now >= missed_at_ + kPause) return missed();
  if (granted_.silence_ns == 0) {
    silent_at_ = back_at_ = 0;
    return std::nullopt;
  }
  const bool is_silent = now >= last_ + granted_.silence_ns;
  if (silent_at_ == 0) return is_silent ? std::optional(missing(now)) : std::nullopt;
  if (is_silent) back_at_ = 0;  // silent once more
  if (back_at_ == 0 || now < back_at_ + kHold) return std::nullopt;
  return restored();
}

// --- what is reported ----------------------------------------------------------------------------

control::Event LocalSource::event(const char* kind) const {
  control::Event out;
  out.kind = kind;
  out.publisher = granted_.publisher;
  return out;
}

control::Event LocalSource::excess() {
  control::Event out = event("policed");
  out.frames = std::exchange(excess_, 0);
  out.message =
      events_text(out.frames) + " dropped of programs on this gateway: more than is admitted";
  return out;
}

control::Event LocalSource::missed() {
  control::Event out = event("missed");
  out.missing = std::exchange(missed_, 0);
  out.message = events_text(out.missing) +
                " lost of programs on this gateway: this program did not read them in time, or the "
                "gates were closed";
  return out;
}

control::Event LocalSource::missing(std::uint64_t now) {
  silent_at_ = last_;
  back_at_ = 0;
  control::Event out = event("missing");
  out.silent_ns = now - last_;
  out.missing = out.silent_ns / std::max<std::uint64_t>(granted_.period_ns, 1);
  out.message = "nothing has come from programs on this gateway for " + time_text(out.silent_ns) +
                ": " + events_text(out.missing) + " missing";
  return out;
}

control::Event LocalSource::restored() {
  control::Event out = event("restored");
  out.silent_ns = back_at_ - silent_at_;
  const std::uint64_t period = std::max<std::uint64_t>(granted_.period_ns, 1);
  const std::uint64_t events = (out.silent_ns + period / 2) / period;
  out.missing = events == 0 ? 0 : events - 1;
  out.message = "events of programs on this gateway come again: for " + time_text(out.silent_ns) +
                " they stayed out, or came with breaks";
  silent_at_ = back_at_ = 0;
  return out;
}

}  // namespace mlcca::client
