// SPDX-License-Identifier: BSD-2-Clause
#include "core/members.hpp"

#include <utility>

namespace mlcca::core {

template <class End>
std::size_t Members::Ends<End>::add(End end, AdmissionId admission) {
  if (free.empty()) {
    slots.push_back({std::move(end), admission});
    return slots.size() - 1;
  }
  const std::size_t i = free.back();
  free.pop_back();
  slots[i] = {std::move(end), admission};
  return i;
}

template <class End>
void Members::Ends<End>::remove(std::size_t i) {
  slots[i] = {};
  free.push_back(i);
}

Members::Members(const System& system) : by_channel_(system.channels.size()) {
  publishers_.slots.reserve(system.publishers.size());
  subscribers_.slots.reserve(system.subscribers.size());
  for (const Publisher& p : system.publishers)
    by_channel_[p.channel].publishers.push_back(publishers_.add(p, 0));
  for (const Subscriber& s : system.subscribers)
    by_channel_[s.channel].subscribers.push_back(subscribers_.add(s, 0));
}

std::size_t Members::add(Publisher publisher, AdmissionId admission) {
  const std::size_t channel = publisher.channel;
  const std::size_t i = publishers_.add(std::move(publisher), admission);
  by_channel_[channel].publishers.push_back(i);
  admitted_[admission].publisher = i;
  return i;
}

std::size_t Members::add(Subscriber subscriber, AdmissionId admission) {
  const std::size_t channel = subscriber.channel;
  const std::size_t i = subscribers_.add(std::move(subscriber), admission);
  by_channel_[channel].subscribers.push_back(i);
  admitted_[admission].subscriber = i;
  return i;
}

void Members::remove(AdmissionId admission) {
  const auto found = admitted_.find(admission);
  if (found == admitted_.end()) return;
  if (const auto p = found->second.publisher) {
    std::erase(by_channel_[publisher(*p).channel].publishers, *p);
    publishers_.remove(*p);
  }
  if (const auto s = found->second.subscriber) {
    std::erase(by_channel_[subscriber(*s).channel].subscribers, *s);
    subscribers_.remove(*s);
  }
  admitted_.erase(found);
}

}  // namespace mlcca::core
