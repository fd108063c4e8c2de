// SPDX-License-Identifier: BSD-2-Clause
// The endpoints of all channels: those that the description lists and those that were admitted at
// run time.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "core/model/system.hpp"

namespace mlcca::core {

/// Identifies a run-time admission. 0 stands for an endpoint of the description, which has none.
using AdmissionId = std::uint64_t;

/// Returns the admissions to which a publisher and its subscribers belong, without duplicates.
/// Described endpoints (Id{}) are left out. No two of the subscribers may belong to the same
/// admission; this keeps the work linear, as a channel may have thousands of subscribers.
template <class Id, class IdOf>
std::vector<Id> each_once(Id of_publisher, std::span<const std::size_t> subscribers,
                          const IdOf& id_of) {
  std::vector<Id> ids;
  const bool described = of_publisher == Id{};
  ids.reserve(subscribers.size() + 1);
  if (!described) ids.push_back(of_publisher);
  for (const std::size_t s : subscribers) {
    const Id id = id_of(s);
    if (id == Id{} || (!described && id == of_publisher)) continue;
    ids.push_back(id);
  }
  return ids;
}

/// Numbers all endpoints and finds them by channel and by admission. A described endpoint keeps the
/// index that it has in the System, which must outlive this object; those admitted at run time get
/// the indices behind. An index stays valid as long as its endpoint is a member and may be used
/// again after remove().
class Members {
 public:
  explicit Members(const System& system);

  /// Adds an endpoint and returns its index. An admission may add at most one publisher and one
  /// subscriber.
  std::size_t add(Publisher publisher, AdmissionId admission);
  std::size_t add(Subscriber subscriber, AdmissionId admission);
  /// Adds the publisher, the subscriber or both that an admission consists of.
  void add(AdmissionId admission, std::optional<Publisher>&& publisher,
           std::optional<Subscriber>&& subscriber);
  /// Removes the endpoints of an admission; does nothing if there are none.
  void remove(AdmissionId admission);

  [[nodiscard]] const Publisher& publisher(std::size_t i) const { return publishers_[i]; }
  [[nodiscard]] const Subscriber& subscriber(std::size_t i) const { return subscribers_[i]; }
  [[nodiscard]] AdmissionId admission_of_publisher(std::size_t i) const {
    return publishers_.admission_of(i);
  }
  [[nodiscard]] AdmissionId admission_of_subscriber(std::size_t i) const {
    return subscribers_.admission_of(i);
  }

  [[nodiscard]] const std::vector<std::size_t>& publishers_of(std::size_t channel) const {
    return by_channel_[channel].publishers;
  }
  [[nodiscard]] const std::vector<std::size_t>& subscribers_of(std::size_t channel) const {
    return by_channel_[channel].subscribers;
  }
  /// The indices of the endpoints that an admission added.
  struct Admitted {
    std::optional<std::size_t> publisher;
    std::optional<std::size_t> subscriber;
  };
  /// Both are nullopt if there is no such admission.
  [[nodiscard]] Admitted admitted(AdmissionId admission) const {
    const auto found = admitted_.find(admission);
    return found == admitted_.end() ? Admitted{} : found->second;
  }
  /// The number of (publisher, subscriber) pairs in one channel in which at least one of the two
  /// was admitted at run time. Quotas limit it, since the work of a decision grows with it.
  [[nodiscard]] std::size_t admitted_pairs() const { return admitted_pairs_; }
  [[nodiscard]] std::size_t channels() const { return by_channel_.size(); }

 private:
  /// The endpoints of one kind: the described ones, followed by a slot for each admitted one.
  /// `free_` lists the empty slots (as indices of endpoints).
  template <class End>
  class Ends {
   public:
    explicit Ends(const std::vector<End>& described) : described_(&described) {}

    const End& operator[](std::size_t i) const {
      return i < described_->size() ? (*described_)[i] : slot(i).end.value();
    }
    [[nodiscard]] AdmissionId admission_of(std::size_t i) const {
      return i < described_->size() ? 0 : slot(i).admission;
    }
    std::size_t add(End end, AdmissionId admission);
    void remove(std::size_t i);

   private:
    struct Slot {
      std::optional<End> end;
      AdmissionId admission = 0;
    };
    [[nodiscard]] const Slot& slot(std::size_t i) const { return slots_[i - described_->size()]; }

    const std::vector<End>* described_;
    std::vector<Slot> slots_;
    std::vector<std::size_t> free_;
  };
  struct Channel {
    std::vector<std::size_t> publishers;
    std::vector<std::size_t> subscribers;
  };
  Ends<Publisher> publishers_;
  Ends<Subscriber> subscribers_;
  std::vector<Channel> by_channel_;
  std::unordered_map<AdmissionId, Admitted> admitted_;
  std::size_t admitted_pairs_ = 0;
};

}  // namespace mlcca::core
