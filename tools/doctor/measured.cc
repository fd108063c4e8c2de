// SPDX-License-Identifier: BSD-2-Clause
#include "tools/doctor/measured.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/many.hpp"

namespace mlcca::doctor {
namespace {

constexpr unsigned kDeepest = 64;  ///< the largest depth that a description can state
/// An error frame and a link message no further apart than this (ns) report the same bus-off: the
/// kernel delays link changes by up to a second.
constexpr std::uint64_t kTogether = 2'000'000'000;
constexpr const char* kNoAcknowledge =
    "no node acknowledges: is another node on the bus, terminated and at this rate?";

std::uint64_t apart(std::uint64_t a, std::uint64_t b) { return a > b ? a - b : b - a; }

double us(std::uint64_t ns) { return std::round(static_cast<double>(ns) / 100) / 10; }
double seconds(std::uint64_t ns) { return std::round(static_cast<double>(ns) / 1e8) / 10; }

/// The time from the start of a frame to the end of its last bit, without the intermission.
std::uint64_t at_least(const core::can::Timing& timing, core::can::WireLength length) {
  length.slow -= core::can::kIntermission;
  return core::can::wire_time(timing, length);
}

const char* not_the_drivers_echo() {
  return "the driver does not echo (IFF_ECHO is off): what comes back says that a frame was "
         "queued, not that it was sent";
}

Line judge_echo_times(const Device& device, std::span<const Single> singles) {
  std::uint64_t first = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t last = 0;
  std::uint64_t needs = 0;
  for (const Single& s : singles) {
    const auto took = s.echoes_ns.front() > s.sent_ns ? s.echoes_ns.front() - s.sent_ns : 0;
    first = std::min(first, took);
    last = std::max(last, took);
    needs = at_least(timing_of(device), s.length);
    if (static_cast<double>(took) < static_cast<double>(needs) * (1 - kTolerance))
      return {"echo", Outcome::failed,
              fmt::format("comes {} us after the frame was handed over, which is on the bus for {} "
                          "us: the echo is older than the frame",
                          us(took), us(needs))};
  }
  return {"echo", Outcome::ok,
          fmt::format("{} of {} frames came back once, {} to {} us after they were handed over, of "
                      "which they take {} us on the bus",
                      singles.size(), singles.size(), us(first), us(last), us(needs))};
}

}  // namespace

void PassageCount::take_seen(const Seen& seen) {
  if (seen.error != 0) {
    ++passage_.errors;
    return;
  }
  if (seen.own) ++passage_.echoed;
  if (!first_ns_) {
    if (seen.own) first_ns_ = seen.ns;
    return;
  }
  const auto length = core::can::wire_length(seen.frame);
  since_own_.slow += length.slow;
  since_own_.fast += length.fast;
  if (!seen.own) {
    ++foreign_since_own_;
    return;
  }
  const auto passed = std::exchange(since_own_, {});
  passage_.length.slow += passed.slow;
  passage_.length.fast += passed.fast;
  passage_.foreign += std::exchange(foreign_since_own_, 0);
  passage_.took_ns = seen.ns - std::min(seen.ns, *first_ns_);
}

Line judge_echo(const Device& device, std::span<const Single> singles) {
  if (std::ranges::any_of(singles, &Single::refused))
    return {"echo", Outcome::failed,
            fmt::format(
                "there is no room for a frame (ENOBUFS): its queue is full of frames that no node "
                "acknowledged, or a filter drops it (tc filter show dev {} egress)",
                device.link.name)};
  const auto none = [](const Single& s) { return s.echoes_ns.empty(); };
  const auto missing = std::ranges::count_if(singles, none);
  if (singles.empty() || none(singles.front()))
    return {"echo", Outcome::failed,
            fmt::format("none within {} ms: {}", kPatienceMs,
                        is_virtual(device) ? "another program drops the frames" : kNoAcknowledge)};
  if (missing != 0)
    return {"echo", Outcome::failed,
            fmt::format("{} of {} frames did not come back: {}", missing, singles.size(),
                        kNoAcknowledge)};
  for (const Single& s : singles)
    if (s.echoes_ns.size() > 1)
      return {"echo", Outcome::failed,
              fmt::format("a frame came back {} times instead of once", s.echoes_ns.size())};
  if (is_virtual(device))
    return {"echo", Outcome::not_tested,
            fmt::format("a virtual bus takes no time, so when a frame came back says nothing; {} "
                        "of {} came back once",
                        singles.size(), singles.size())};
  if (!device.controller.echoes) return {"echo", Outcome::failed, not_the_drivers_echo()};
  return judge_echo_times(device, singles);
}

Line judge_rate(const Device& device, const Passage& passage, bool data) {
  const std::string name = data ? "data rate measured" : "bit rate measured";
  const auto timing = timing_of(device);
  if (passage.echoed < passage.sent)
    return {name, Outcome::failed,
            fmt::format("{} of {} frames did not come back", passage.sent - passage.echoed,
                        passage.sent)};
  if (passage.echoed < 2) return {name, Outcome::failed, "there was no room for two frames"};
  if (passage.took_ns == 0) return {name, Outcome::failed, "all frames came back at the same time"};
  const auto took = static_cast<double>(passage.took_ns);
  const auto expected = static_cast<double>(core::can::wire_time(timing, passage.length));
  const double off = took / expected - 1;
  const double slow_ns =
      data ? static_cast<double>(core::can::wire_time(timing, {.slow = passage.length.slow})) : 0;
  const double bits = passage.length.fast;
  const double rate =
      data ? bits * 1e9 / std::max(took - slow_ns, 1.0) : timing.bitrate * expected / took;
  std::string text =
      fmt::format("{:.0f} bit/s by {} back to back", rate, many(passage.echoed, "frame"));
  if (passage.foreign != 0) text += fmt::format(" and {} of others", passage.foreign);
  text += fmt::format(", which took {:.1f} % {} than their bits do", std::abs(off) * 100,
                      off < 0 ? "less" : "more");
  if (passage.errors != 0) text += "; " + many(passage.errors, "error frame");
  if (off > kTolerance)
    return {name, Outcome::failed,
            text +
                ": the bit rate is another one, frames were sent again, or the controller leaves "
                "gaps between its frames, in which one of lower priority wins the bus"};
  if (off < -kTolerance)
    return {name, Outcome::failed,
            text + ": the bit rate is another one, or echoes come before the frames were sent"};
  return {name, Outcome::ok, text + fmt::format(" (tolerance {:.0f} %)", kTolerance * 100)};
}

Line judge_depth(const Device& device, std::span<const Filling> fillings,
                 std::optional<unsigned> described) {
  const auto limit = device.controller.queue_limit;
  unsigned most = 0;
  for (const Filling& f : fillings) {
    if (f.echoed < f.taken)
      return {"queue depth", Outcome::failed,
              fmt::format("{} of {} never came back", f.taken - f.echoed,
                          many(f.taken, "frame that was taken", "frames that were taken"))};
    if (!f.refused)
      return {"queue depth", Outcome::not_tested,
              fmt::format("{} taken without an end: they leave as fast as they come",
                          many(f.taken, "frame was", "frames were"))};
    most = std::max(most, f.taken - std::min(f.left, f.taken));
  }
  if (most < limit)
    return {"queue depth", Outcome::failed,
            fmt::format("no room for more than {}, though the queue alone should hold {}",
                        many(most, "frame"), limit)};
  const unsigned depth = std::max(most - limit, 1U);
  const std::string text = fmt::format(
      "{} before there was no room, {} in the queue and {} behind it; all came "
      "back: fifo-depth=\"{}\" queue-length=\"{}\" of its Port",
      many(most, "frame"), limit, most - limit, depth, limit);
  if (depth > kDeepest)
    return {"queue depth", Outcome::failed,
            text + fmt::format("; more than the {} that a description can say", kDeepest)};
  if (described && depth > *described)
    return {"queue depth", Outcome::failed,
            text + fmt::format("; the description says {}, so bounds are too small", *described)};
  return {"queue depth", Outcome::ok, text};
}

Line judge_bus_off(const BusOff& seen) {
  const auto failed = [](std::string text) {
    return Line{"bus-off", Outcome::failed, std::move(text)};
  };
  if (!seen.frame_ns && !seen.link_ns)
    return {"bus-off", Outcome::not_tested,
            fmt::format("none came within {} s: short CAN_H and CAN_L in that time", seen.seconds)};
  if (!seen.link_ns)
    return failed("an error frame said bus-off, the state of the interface did not");
  if (!seen.frame_ns)
    return failed("the state of the interface was bus-off, no error frame said so");
  if (apart(*seen.frame_ns, *seen.link_ns) > kTogether)
    return failed(fmt::format("the error frame and the state of the interface are {} s apart",
                              seconds(apart(*seen.frame_ns, *seen.link_ns))));
  if (!seen.recovered_ns)
    return failed(fmt::format("reported, but it did not end within {} s", seen.seconds));
  return {
      "bus-off", Outcome::ok,
      fmt::format("reported by an error frame and by the state of the interface; over {} s later",
                  seconds(*seen.recovered_ns - std::min(*seen.recovered_ns, *seen.link_ns)))};
}

Line judge_counters(const std::optional<net::ErrorCounters>& before,
                    const std::optional<net::ErrorCounters>& after) {
  if (!before || !after) return {"error counters", Outcome::not_tested, "the driver has none"};
  if (after->sending <= before->sending && after->receiving <= before->receiving)
    return {
        "error counters", Outcome::ok,
        fmt::format("did not grow: sending {}, receiving {}", after->sending, after->receiving)};
  return {"error counters", Outcome::failed,
          fmt::format("grew: sending {} to {}, receiving {} to {}: see wiring, termination and bit "
                      "rates",
                      before->sending, after->sending, before->receiving, after->receiving)};
}

std::optional<std::string> why_no_rate(const Device& device, bool data) {
  if (is_virtual(device)) return "a virtual bus takes no time: only on a controller";
  if (!device.controller.echoes)
    return std::string(not_the_drivers_echo()) + ": measure at another node, with candump -td";
  if (data && (!device.controller.fd || device.link.data_bitrate <= device.link.bitrate))
    return "no FD with a data bit rate of its own";
  return {};
}

std::optional<std::string> why_no_depth(const Device& device) {
  const auto& c = device.controller;
  if (c.queue.empty() || c.queue == "noqueue" || c.queue == "noop")
    return "it has no queue, so nothing waits";
  if (!c.echoes) return std::string(not_the_drivers_echo()) + ": see the manual of the controller";
  if (c.queue_limit == 0)
    return fmt::format(
        "how many frames {} holds is not known: tc qdisc replace dev {} root "
        "pfifo_fast",
        c.queue, device.link.name);
  return {};
}

}  // namespace mlcca::doctor
