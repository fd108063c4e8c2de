// SPDX-License-Identifier: BSD-2-Clause
// The followers of each subject, for networks whose frames carry the subject.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "relay/layers/layer.hpp"

namespace mlcca::relay {

inline constexpr std::size_t kSubjectOctets = 8;

/// The followers of each subject on one network. `Address`: the type of a sender's address; a
/// default-constructed one means any sender.
template <class Address>
class Followers {
 public:
  void add(Layer::Follower follower, std::uint64_t subject, Address address, std::size_t longest) {
    by_subject_[subject].push_back({follower, std::move(address), longest});
  }
  void remove(Layer::Follower follower, std::uint64_t subject) {
    const auto known = by_subject_.find(subject);
    if (known == by_subject_.end()) return;
    std::erase_if(known->second, [&](const One& one) { return one.follower == follower; });
    if (known->second.empty()) by_subject_.erase(known);
  }
  [[nodiscard]] bool any(std::uint64_t subject) const { return by_subject_.contains(subject); }

  /// Hands an event to the followers of its sender or, if there are none, to those of any sender.
  /// An event that is longer than a follower takes is counted in `losses`.
  void hand_over(std::uint64_t subject, const Address& from, Octets event, std::uint64_t unix_ns,
                 const Layer::OnEvent& on_event, Losses& losses) const {
    const auto known = by_subject_.find(subject);
    if (known == by_subject_.end()) return;
    const auto& all = known->second;
    const bool is_stated = std::ranges::find(all, from, &One::address) != all.end();
    for (const One& one : all) {
      if (one.address != (is_stated ? from : Address{})) continue;
      if (event.size() > one.longest)
        ++losses.too_long;
      else
        on_event({one.follower, event, unix_ns, source_of(from), station_of(from)});
    }
  }

 private:
  /// As Layer::Arrival has it.
  static std::uint32_t source_of(const Address& from) {
    if constexpr (std::is_convertible_v<Address, std::uint32_t>) return from;
    return 0;
  }
  static std::string_view station_of(const Address& from) {
    if constexpr (std::is_convertible_v<const Address&, std::string_view>) return from;
    return {};
  }
  /// A follower of a subject, and the sender whose events it takes.
  struct One {
    Layer::Follower follower = 0;
    Address address;
    std::size_t longest = 0;
  };
  std::unordered_map<std::uint64_t, std::vector<One>> by_subject_;
};

}  // namespace mlcca::relay
