// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/health_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "base/drop_watch.hpp"
#include "base/many.hpp"
#include "core/gates/relay_gate.hpp"
#include "daemon/gateway/health.hpp"

namespace mlcca {
namespace {

void add_interface(const control::Interface& i, std::vector<std::string>& to) {
  if (!i.problem.empty())
    to.push_back(fmt::format("{} ({}): {}", i.name, i.network, i.problem));
  else if (i.ifindex != 0 && !i.attached && i.profile != "none")
    to.push_back(fmt::format("no gate is attached to {} ({})", i.name, i.network));
  if (!i.drift.empty()) to.push_back(i.drift);
  if (i.bypassed != 0)
    to.push_back(fmt::format("{} sent past the gate of {} ({})",
                             many(i.bypassed, "frame was", "frames were"), i.name, i.network));
}

/// The line about the withdrawn channels with these subjects: names the first ones and counts the
/// others. Empty if the description has none of them.
std::string withdrawn_words(const core::State& state, const std::vector<std::string>& subjects) {
  constexpr std::size_t named = 8;
  std::vector<std::string> names;
  std::size_t more = subjects.size();
  for (auto at = subjects.begin(); at != subjects.end() && names.size() < named; ++at) {
    --more;
    if (const auto channel = state.find_channel(*at))
      names.push_back(state.system().channels[*channel].name);
  }
  if (names.empty()) return {};
  return fmt::format("withdrawn by an operator, until it is reinstated: {}{}",
                     fmt::join(names, ", "),
                     more == 0 ? std::string() : fmt::format(" and {} more", more));
}

}  // namespace

std::string words_of(Lapse reason, const std::string& grace) {
  if (reason == Lapse::lease)
    return "the lease of this gateway ended before the store had confirmed a beat";
  return "the daemon gave no heart-beat for more than " + grace;
}

std::vector<std::string> HealthReport::problems() const {
  std::vector<std::string> problems;
  if (parts_.gates.out_of_hand())
    problems.emplace_back("no gate can be attached to an interface: everything is denied");
  if (!parts_.links.problem().empty())
    problems.push_back(parts_.links.problem() + ": what is in force stays until they can be read");
  if (!parts_.gates.orphans_unknown().empty())
    problems.push_back(unlisted_gates(parts_.gates.orphans_unknown()));
  if (!parts_.recorder.problem().empty()) problems.push_back(parts_.recorder.problem());
  if (!parts_.forwarding.problem().empty()) problems.push_back(parts_.forwarding.problem());
  return problems;
}

/// Adds the problems of the daemon itself and of the description.
void HealthReport::add_own(std::vector<std::string>& to) const {
  if (parts_.modes.is_audit())
    to.push_back(
        fmt::format("audit mode{}: nothing is dropped, data that was not admitted passes",
                    parts_.modes.is_introduction() ? " until 'mlccactl mode enforce'" : ""));
  if (parts_.control.lapsed())
    to.emplace_back("the heart-beat came too late: everything is denied");
  if (const std::int64_t now = parts_.clock.monotonic_s(); lapse_ && now - lapse_->second < kRecent)
    to.push_back(fmt::format("the gates were closed until {} s ago, because {}",
                             now - lapse_->second, words_of(lapse_->first, "the grace")));
  std::ranges::move(problems(), std::back_inserter(to));
  std::ranges::move(parts_.safeguards.problems(), std::back_inserter(to));
  if (!parts_.reloads.last_error().empty())
    to.push_back("the latest reload was refused, the former description is in force: " +
                 parts_.reloads.last_error());
  if (std::string words = withdrawn_words(*parts_.scene.state, parts_.recorder.contents().released);
      !words.empty())
    to.push_back(std::move(words));
  std::ranges::move(parts_.presence.problems(), std::back_inserter(to));
  if (parts_.membership != nullptr)
    std::ranges::move(parts_.membership->problems(), std::back_inserter(to));
  std::ranges::move(parts_.meshes.problems(), std::back_inserter(to));
  if (std::string why = parts_.tags.problem(); !why.empty()) to.push_back(std::move(why));
  for (const Tag& tag : parts_.tags.all())
    if (!tag.problem().empty()) to.push_back(tag.name + ": " + tag.problem());
  for (const auto& [id, why] : parts_.admissions.left_out()) to.push_back(words_of(why));
}

control::Health HealthReport::health(const std::vector<control::Interface>& interfaces) const {
  const core::State& state = *parts_.scene.state;
  std::vector<std::string> lines;
  add_own(lines);
  for (const control::Interface& i : interfaces) add_interface(i, lines);
  for (std::size_t n = 0; n < state.world().conditions.size(); ++n) {
    const core::Condition& condition = state.world().conditions[n];
    const core::Network& network = state.system().networks[n];
    if (!condition.available && state.system().gateways[parts_.scene.self].port_on(n) == nullptr)
      lines.push_back(fmt::format("{}: {}", network.name, condition.problem));
  }
  for (const std::string& name : parts_.gates.undescribed())
    lines.push_back(undescribed_line(name));
  for (std::size_t n = 0; n < state.system().networks.size(); ++n)
    if (const std::string problem = core::relay_problem(state.system(), n, parts_.scene.self);
        !problem.empty())
      lines.push_back(problem + ": " + core::relay_hint(state.system(), n, parts_.scene.self));
  parts_.deliveries.add_to(lines);
  if (state.refused() != 0)
    lines.push_back(many(state.refused(), "delivery is", "deliveries are") +
                    " refused: 'mlccactl channels' says why");
  return health_of(parts_.control.is_open() && !parts_.control.lapsed(), std::move(lines));
}

}  // namespace mlcca
