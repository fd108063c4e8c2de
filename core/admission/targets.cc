// SPDX-License-Identifier: BSD-2-Clause
// The targets of a channel's events, and the joint requirements of its endpoints.
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/admission/route_check.hpp"
#include "core/model/user_values.hpp"
#include "mlcca/compose.hpp"

namespace mlcca::core {

std::vector<Target> targets_of(const Members& members, std::size_t channel) {
  std::vector<Target> targets;
  for (const std::size_t s : members.subscribers_of(channel)) {
    const Place place = members.subscriber(s).place;
    auto it = std::ranges::find(targets, place, &Target::place);
    if (it == targets.end()) it = targets.insert(targets.end(), {place, {}});
    it->subscribers.push_back(s);
  }
  return targets;
}

JointRequirements asked_together(const Situation& situation, std::size_t publisher,
                                 const std::vector<std::size_t>& subscribers, std::size_t set) {
  const Publisher& p = situation.members.publisher(publisher);
  const AttributeSet& offered = attributes_in(p, set);
  JointRequirements asked{requirement_between(offered, {}), user_values_in(p, set)};
  for (const std::size_t s : subscribers) {
    const Subscriber& subscriber = situation.members.subscriber(s);
    asked.set = with_subscriber(asked.set, offered, attributes_in(subscriber, set));
    const UserValues& user = user_values_in(subscriber, set);
    if (!user.empty()) asked.user = strictest(situation.system, asked.user, user);
  }
  return asked;
}

Verdict undecided(const Situation& situation, std::size_t channel, std::size_t publisher,
                  const Target& target, std::size_t set) {
  Verdict v;
  v.channel = channel;
  v.publisher = publisher;
  v.to = target.place;
  v.subscribers = target.subscribers;
  v.set = set;
  v.sporadic = situation.system.channels[channel].arrival == Arrival::sporadic;
  JointRequirements asked = asked_together(situation, publisher, target.subscribers, set);
  v.requirement = asked.set;
  v.user_requirement = std::move(asked.user);
  return v;
}

}  // namespace mlcca::core
