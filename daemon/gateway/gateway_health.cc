// SPDX-License-Identifier: BSD-2-Clause
// What is wrong, for people and for monitoring systems.
#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "core/model/text.hpp"
#include "daemon/gateway/gateway.hpp"

namespace mlcca {
namespace {

std::string deliveries(std::size_t n) {
  return n == 1 ? "1 delivery is" : fmt::format("{} deliveries are", n);
}

void add_interface(const control::Interface& i, std::vector<std::string>& to) {
  if (!i.problem.empty())
    to.push_back(fmt::format("{} ({}): {}", i.name, i.network, i.problem));
  else if (i.ifindex != 0 && !i.gated && i.profile != "none")
    to.push_back(fmt::format("{} ({}) is not held by a gate", i.name, i.network));
  if (!i.drift.empty()) to.push_back(i.drift);
  if (i.bypassed != 0)
    to.push_back(
        fmt::format("{} frames were sent past the gate of {} ({})", i.bypassed, i.name, i.network));
}

}  // namespace

std::vector<core::GateEntry> Gateway::shared_entries_of(std::size_t channel) const {
  return core::shared_entries(scene_.state->system(), scene_.state->members(), channel,
                              scene_.state->decisions()[channel].verdicts, scene_.self);
}

std::vector<std::string> Gateway::troubles_of(const core::Verdict& v, const core::GateState& rules,
                                              const std::vector<core::GateEntry>& shared,
                                              std::optional<control::Watch> watch) const {
  Observed seen;
  seen.watch = std::move(watch);
  if (const auto why = not_carried_.find(v.channel); why != not_carried_.end())
    seen.not_forwarded = why->second;
  const std::int64_t now = monotonic_s();
  for (const core::GateRule& rule : rules) {
    if (ports_.gate(rule.entry.port) == nullptr) continue;
    seen.passages.push_back(
        {.network = ports_.network_of(rule.entry.port),
         .leaves = rule.entry.direction == core::Direction::egress,
         .is_shared = std::ranges::binary_search(shared, rule.entry),
         .frames = ports_.frames({rule}),
         .excess = drops_.recent({rule.entry, Drop::excess}, now),
         .misfits = drops_.recent({rule.entry, Drop::misfit}, now),
         .would_be_misfits = drops_.recent({rule.entry, Drop::would_be_misfit}, now)});
  }
  // Only where nothing comes somebody asks what comes instead.
  const auto in =
      std::ranges::find(rules, core::Direction::ingress,
                        [](const core::GateRule& rule) { return rule.entry.direction; });
  if (in != rules.end() && seen.watch && (seen.watch->missing_now || seen.watch->events == 0)) {
    const std::size_t port = in->entry.port;
    seen.strangers = unknown_.recent({port, Fate::dropped}, now) +
                     unknown_.recent({port, Fate::let_through}, now);
    if (seen.strangers != 0) seen.stranger = ports_.latest_stranger(port);
  }
  return troubles(seen);
}

std::vector<std::string> Gateway::own_problems() const {
  std::vector<std::string> problems;
  if (ports_.out_of_hand())
    problems.emplace_back("an interface cannot be held: everything is denied");
  if (!links_.problem().empty())
    problems.push_back(links_.problem() + ": what is in force stays until they can be read");
  if (!ports_.orphans_unknown().empty())
    problems.push_back(ports_.orphans_unknown() +
                       ": a gate without pins may be left on an interface that is not described");
  if (journal_gone_.lasts()) problems.push_back(journal_gone_.text());
  if (!forwarder_.problem().empty()) problems.push_back(forwarder_.problem());
  return problems;
}

/// Of the daemon itself and of the description.
void Gateway::add_own_troubles(std::vector<std::string>& to) const {
  if (control_.mode() == enforce::Mode::audit)
    to.emplace_back("audit mode: nothing is dropped, data that was not admitted passes");
  if (control_.lapsed()) to.emplace_back("the heart-beat came too late: everything is denied");
  std::ranges::move(own_problems(), std::back_inserter(to));
  if (unlocked_.lasts()) to.push_back(unlocked_.text());
  if (unpinned_.lasts()) to.push_back(unpinned_.text());
  if (!last_error_.empty())
    to.push_back("the latest reload was refused, the former description is in force: " +
                 last_error_);
  for (const Tag& tag : tags_.all())
    if (!tag.problem().empty()) to.push_back(tag.name + ": " + tag.problem());
  for (const auto& [id, why] : left_out_) to.push_back(fmt::format("admission {}: {}", id, why));
}

/// Channels in which something was wrong when their drops were last looked at, or of which the
/// kernel has told so since.
void Gateway::add_troubles_of_deliveries(std::vector<std::string>& to) const {
  for (const std::size_t channel : troubled_) {
    if (channel >= scene_.state->decisions().size()) break;
    const auto shared = shared_entries_of(channel);
    for (const core::Verdict& v : scene_.state->decisions()[channel].verdicts) {
      if (!v.granted) continue;
      const auto rules =
          core::gate_state(scene_.state->system(), scene_.state->members(), v, scene_.self);
      for (const std::string& line : troubles_of(v, rules, shared, ports_.watch(rules)))
        to.push_back(
            fmt::format("{} from {} ({}) to {}: {}", scene_.state->system().channels[channel].name,
                        core::name_of(scene_.state->system(),
                                      scene_.state->members().publisher(v.publisher).place),
                        scene_.state->members().publisher(v.publisher).name,
                        core::name_of(scene_.state->system(), v.to), line));
    }
    // What is beyond is counted, and told by `channels`.
    if (to.size() > 2 * control::kMostReasons) return;
  }
}

control::Health Gateway::health(const std::vector<control::Interface>& interfaces) const {
  std::vector<std::string> lines;
  add_own_troubles(lines);
  for (const control::Interface& i : interfaces) add_interface(i, lines);
  for (std::size_t n = 0; n < scene_.state->world().conditions.size(); ++n) {
    const core::Condition& condition = scene_.state->world().conditions[n];
    const core::Network& network = scene_.state->system().networks[n];
    if (!condition.available && scene_.state->system().gateways[scene_.self].port_on(n) == nullptr)
      lines.push_back(fmt::format("{}: {}", network.name, condition.problem));
  }
  add_troubles_of_deliveries(lines);
  if (scene_.state->refused() != 0)
    lines.push_back(fmt::format("{} refused: 'mlccactl channels' says why",
                                deliveries(scene_.state->refused())));
  return health_of(control_.is_open() && !control_.lapsed(), std::move(lines));
}

}  // namespace mlcca
