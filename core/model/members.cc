// SPDX-License-Identifier: BSD-2-Clause
#include "core/model/members.hpp"

#include <utility>

namespace mlcca::core {

template <class End>
std::size_t Members::Ends<End>::add(End end, AdmissionId admission) {
  if (free_.empty()) {
    slots_.push_back({std::move(end), admission});
    return described_->size() + slots_.size() - 1;
  }
  const std::size_t i = free_.back();
  free_.pop_back();
  slots_[i - described_->size()] = {std::move(end), admission};
  return i;
}

template <class End>
void Members::Ends<End>::remove(std::size_t i) {
  slots_[i - described_->size()] = {};
  free_.push_back(i);
}

Members::Members(const System& system)
    : publishers_(system.publishers),
      subscribers_(system.subscribers),
      by_channel_(system.channels.size()) {
  for (std::size_t i = 0; i < system.publishers.size(); ++i)
    by_channel_[system.publishers[i].channel].publishers.push_back(i);
  for (std::size_t i = 0; i < system.subscribers.size(); ++i)
    by_channel_[system.subscribers[i].channel].subscribers.push_back(i);
}

std::size_t Members::add(Publisher publisher, AdmissionId admission) {
  const std::size_t channel = publisher.channel;
  const std::size_t i = publishers_.add(std::move(publisher), admission);
  by_channel_[channel].publishers.push_back(i);
  admitted_pairs_ += by_channel_[channel].subscribers.size();
  admitted_[admission].publisher = i;
  return i;
}

std::size_t Members::add(Subscriber subscriber, AdmissionId admission) {
  const std::size_t channel = subscriber.channel;
  const std::size_t i = subscribers_.add(std::move(subscriber), admission);
  by_channel_[channel].subscribers.push_back(i);
  admitted_pairs_ += by_channel_[channel].publishers.size();
  admitted_[admission].subscriber = i;
  return i;
}

void Members::add(AdmissionId admission, std::optional<Publisher>&& publisher,
                  std::optional<Subscriber>&& subscriber) {
  if (publisher) add(std::move(*publisher), admission);
  if (subscriber) add(std::move(*subscriber), admission);
}

void Members::remove(AdmissionId admission) {
  const auto found = admitted_.find(admission);
  if (found == admitted_.end()) return;
  if (const auto p = found->second.publisher) {
    Channel& channel = by_channel_[publisher(*p).channel];
    std::erase(channel.publishers, *p);
    admitted_pairs_ -= channel.subscribers.size();
    publishers_.remove(*p);
  }
  if (const auto s = found->second.subscriber) {
    Channel& channel = by_channel_[subscriber(*s).channel];
    std::erase(channel.subscribers, *s);
    admitted_pairs_ -= channel.publishers.size();
    subscribers_.remove(*s);
  }
  admitted_.erase(found);
}

}  // namespace mlcca::core
