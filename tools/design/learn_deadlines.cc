// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/learn_deadlines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/design/inspect.hpp"
#include "description/read.hpp"
#include "tools/design/queue_lengths.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::string_view kCheckRefuses = "'mlccactl check' refuses";

/// The longest response time of each channel on each bus, ns; nullopt if it has no bound there.
using OnBuses = std::map<std::size_t, std::map<std::size_t, std::optional<std::uint64_t>>>;

OnBuses responses_of(const core::System& system, const core::InspectedBuses& buses) {
  OnBuses out;
  for (std::size_t n = 0; n < buses.assumptions.size(); ++n) {
    for (const core::SentMessage& sent : core::all_sent(buses, n)) {
      const std::size_t channel = system.publishers[sent.message->publisher].channel;
      auto [at, fresh] = out[channel].try_emplace(n, std::uint64_t{0});
      if (!sent.response.bounded)
        at->second.reset();
      else if (at->second)
        at->second = std::max<std::uint64_t>(*at->second, sent.response.response);
    }
  }
  return out;
}

}  // namespace

std::set<std::string> too_often_for_transport(const core::System& system,
                                              const core::InspectedBuses& buses) {
  std::set<std::string> out;
  for (std::size_t n = 0; n < buses.assumptions.size(); ++n)
    for (const core::SentMessage& sent : core::all_sent(buses, n))
      if (!sent.response.bounded && sent.message->message && sent.message->message->pauses != 0)
        out.insert(system.channels[system.publishers[sent.message->publisher].channel].name);
  return out;
}

std::map<std::string, std::uint64_t> deadlines_that_hold(const core::System& system,
                                                         const core::InspectedBuses& buses) {
  std::map<std::string, std::uint64_t> out;
  // A Period without a Deadline requires a Deadline of that length, for each publisher its own.
  std::map<std::size_t, std::uint64_t> shortest;
  for (const core::Publisher& publisher : system.publishers) {
    const std::uint64_t period = core::attributes_in(publisher, 0)[Attribute::period];
    const auto [known, is_first] = shortest.try_emplace(publisher.channel, period);
    if (!is_first) known->second = std::min(known->second, period);
  }
  for (const auto& [channel, on_buses] : responses_of(system, buses)) {
    // Each gateway between two buses adds the Latency of its Provision.
    std::uint64_t takes = 0;
    for (const core::Gateway& gateway : system.gateways)
      if (on_buses.size() > 1) takes += gateway.provision[Attribute::latency];
    bool bounded = true;
    for (const auto& [bus, response] : on_buses) {
      bounded = bounded && response.has_value();
      takes += response.value_or(0);
    }
    if (bounded && takes > shortest[channel])
      out.emplace(system.channels[channel].name, takes + takes / 4);
  }
  return out;
}

namespace {

struct Inspected {
  std::vector<core::Finding> findings;
  core::InspectedBuses buses;
};

class Holding {
 public:
  Holding(const learn::Observer& observer, const std::vector<std::string>& names,
          learn::DraftOptions options)
      : observer_(observer), names_(names), options_(std::move(options)) {
    draw();
    if (system_ && !refused_transport()) return;
    // A longer Deadline changes what is granted, which delays other channels, so this is repeated.
    constexpr int rounds = 8;
    for (int round = 0; system_ && round < rounds && allow_more(); ++round) draw();
  }

  [[nodiscard]] learn::Draft& draft() { return draft_; }
  /// The errors that a check of the draft finds.
  [[nodiscard]] std::vector<core::Finding> refused() {
    std::vector<core::Finding> out;
    if (!system_) return out;  // the caller reports why it cannot be read
    for (const core::Finding& finding : inspected().findings)
      if (core::info(finding.id).severity == core::Severity::error) out.push_back(finding);
    return out;
  }

 private:
  void draw() {
    draft_ = learn::draft_of(observer_, names_, options_);
    auto system = description::read_memory(draft_.xml, "draft", {}, description::Users::any);
    system_.reset();
    inspected_.reset();
    if (!system) return;
    system_ = std::move(*system);
    system_->sort_bindings();
  }

  /// The findings and response times of the draft. With thousands of messages the inspection takes
  /// most of the time, so it is done once for each draft.
  const Inspected& inspected() {
    if (!inspected_) {
      Inspected& now = inspected_.emplace();
      now.findings = core::inspect(*system_, {}, {}, &now.buses).findings;
    }
    return *inspected_;
  }

  /// Avoids publishers that are too frequent for a transport protocol. False if the draft cannot be
  /// read then.
  bool refused_transport() {
    options_.at_mean = too_often_for_transport(*system_, inspected().buses);
    if (!options_.at_mean.empty()) draw();
    return system_.has_value();
  }

  /// Allows longer queues and Deadlines. False if none is needed.
  bool allow_more() {
    bool more = false;
    if (needs_longer_queues(*system_, inspected().buses)) {
      inspected_.reset();
      for (const auto& [network, frames] : lengthen_queues(*system_)) {
        options_.waiting[names_[network]] = frames;
        more = true;
      }
    }
    for (const auto& [channel, ns] : deadlines_that_hold(*system_, inspected().buses)) {
      std::uint64_t& known = options_.deadlines[channel];
      more = more || known < ns;
      known = std::max(known, ns);
    }
    return more;
  }

  const learn::Observer& observer_;
  const std::vector<std::string>& names_;
  learn::DraftOptions options_;
  learn::Draft draft_;
  std::optional<core::System> system_;
  std::optional<Inspected> inspected_;  ///< of system_
};

}  // namespace

bool is_of_check(std::string_view note) { return note.starts_with(kCheckRefuses); }

std::vector<std::string> notes_on(const std::vector<core::Finding>& refused,
                                  std::string_view what) {
  std::map<core::FindingId, std::size_t> count;
  for (const core::Finding& finding : refused) ++count[finding.id];
  std::vector<std::string> out;
  for (const core::Finding& finding : refused) {
    const std::size_t others = std::exchange(count[finding.id], 0);
    if (others == 0) continue;
    out.push_back(fmt::format(
        "{} a part of {}: {}{}{}{}", kCheckRefuses, what, finding.text,
        finding.hint.empty() ? "" : "; ", finding.hint,
        others == 1 ? ""
                    : fmt::format(" ({}, and {} more)", core::code_of(finding.id), others - 1)));
  }
  return out;
}

learn::Draft draft_that_holds(const learn::Observer& observer,
                              const std::vector<std::string>& names,
                              const learn::DraftOptions& options) {
  Holding best(observer, names, options);
  auto refused = best.refused();
  // Assumptions may be the reason: try other Periods of what was seen once and of bursts, then
  // other bit rates.
  constexpr std::uint64_t second = 1'000'000'000;
  std::vector<learn::DraftOptions> others(3, options);
  for (learn::DraftOptions& other : others) other.times.assumed_period = second;
  others[1].times.period_of_bursts = second / 10;
  others[1].times.at_once = 1024;
  others[1].times.cycles_of_bursts = false;
  others[2].times.few = learn::OfFew::the_mean;
  others[2].times.period_of_bursts = second;
  others[2].times.at_once = 1U << 20U;
  others[2].times.all_bursts = true;
  others[2].times.cycles_of_bursts = false;
  for (const std::size_t slow : {0U, 1U, 2U}) {
    learn::DraftOptions& fast = others.emplace_back(others[slow]);
    for (const std::string& name : names)
      if (!options.bitrates.contains(name)) fast.fast.insert(name);
  }
  for (const learn::DraftOptions& other : others) {
    if (refused.empty()) break;
    Holding next(observer, names, other);
    auto refused_then = next.refused();
    if (refused_then.size() >= refused.size()) continue;
    best.draft() = std::move(next.draft());
    refused = std::move(refused_then);
  }
  std::ranges::move(notes_on(refused, "this draft"), std::back_inserter(best.draft().left_out));
  return std::move(best.draft());
}

}  // namespace mlcca::tools::design
