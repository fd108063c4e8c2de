// SPDX-License-Identifier: BSD-2-Clause
// Who publishes and who subscribes: the described ends and those admitted at run time.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "core/model/system.hpp"

namespace mlcca::core {

/// Id of a run-time admission; 0 means described.
using AdmissionId = std::uint64_t;

/// The admissions of a publisher and of subscribers, each once, where no two of the subscribers are
/// of the same one. The work is linear: a channel may have thousands.
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

/// Described ends have the numbers that they have in the System, which must outlive this; those
/// admitted at run time follow. Numbers stay valid while a member is there; a removed member's may
/// be used again.
class Members {
 public:
  explicit Members(const System& system);

  /// At most one publisher and one subscriber for each admission.
  std::size_t add(Publisher publisher, AdmissionId admission);
  std::size_t add(Subscriber subscriber, AdmissionId admission);
  /// What an admission brings in.
  void add(AdmissionId admission, std::optional<Publisher>&& publisher,
           std::optional<Subscriber>&& subscriber);
  /// Removes what the admission brought in.
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
  /// What an admission brought in.
  struct Admitted {
    std::optional<std::size_t> publisher;
    std::optional<std::size_t> subscriber;
  };
  [[nodiscard]] Admitted admitted(AdmissionId admission) const {
    const auto found = admitted_.find(admission);
    return found == admitted_.end() ? Admitted{} : found->second;
  }
  /// Pairs of a publisher and a subscriber of a channel that there would not be without admissions.
  [[nodiscard]] std::size_t admitted_pairs() const { return admitted_pairs_; }
  [[nodiscard]] std::size_t channels() const { return by_channel_.size(); }

 private:
  /// Ends of one kind: the described ones, then a slot for each that was admitted. One that is
  /// empty is in `free`.
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
