// SPDX-License-Identifier: BSD-2-Clause
// Finds, without a search through all of them, which adopted admissions have a request of another
// gateway.
#pragma once
#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace mlcca {

/// Identifies a request of another gateway. The number alone does not: a gateway that has lost its
/// journal gives the same numbers again.
struct WhichRequest {
  std::size_t gateway = 0;
  std::uint64_t number = 0;  ///< of the admission, at that gateway
  /// Hash of what is asked for.
  std::array<std::uint8_t, 32> content = {};
  auto operator<=>(const WhichRequest&) const = default;
};

/// Admissions ask for requests. One of them holds a request, and carries it for all. Of those with
/// one number only one is held. `Less` orders what it is given two of.
template <class Less = std::less<>>
class RequestIndex {
 public:
  using Admission = std::pair<std::size_t, std::uint64_t>;  ///< gateway, and its own number
  struct Held {
    WhichRequest which;
    Admission holder;
  };

  void ask(const WhichRequest& which, const Admission& by) {
    askers_[which].emplace(Rank::closed, by);
  }
  void ask_no_more(const WhichRequest& which, const Admission& by) {
    const auto it = askers_.find(which);
    if (it == askers_.end()) return;
    it->second.erase({Rank::open, by});
    it->second.erase({Rank::closed, by});
    if (it->second.empty()) askers_.erase(it);
  }
  /// Does nothing if that admission does not ask for the request.
  void set_open(const WhichRequest& which, const Admission& by, bool open) {
    const auto it = askers_.find(which);
    if (it != askers_.end() && it->second.erase({open ? Rank::closed : Rank::open, by}) != 0)
      it->second.emplace(open ? Rank::open : Rank::closed, by);
  }
  /// Another admission that asks for the request, one that is open if there is one.
  [[nodiscard]] std::optional<Admission> other(const WhichRequest& which,
                                               const Admission& than) const {
    const auto it = askers_.find(which);
    if (it == askers_.end()) return std::nullopt;
    for (const auto& [rank, by] : it->second)
      if (by != than) return by;
    return std::nullopt;
  }

  /// No other request with that number is held.
  void hold(const WhichRequest& which, const Admission& holder) {
    held_.insert_or_assign(number_of(which), Held{which, holder});
  }
  void hold_no_more(const WhichRequest& which) { held_.erase(number_of(which)); }
  /// What is held under the number of that request; null: nothing is.
  [[nodiscard]] const Held* held(const WhichRequest& which) const {
    const auto it = held_.find(number_of(which));
    return it == held_.end() ? nullptr : &it->second;
  }

  void clear() {
    askers_.clear();
    held_.clear();
  }

 private:
  enum class Rank : std::uint8_t { open, closed };
  using Number = std::pair<std::size_t, std::uint64_t>;
  static Number number_of(const WhichRequest& which) { return {which.gateway, which.number}; }

  std::map<WhichRequest, std::set<std::pair<Rank, Admission>, Less>, Less> askers_;
  std::map<Number, Held, Less> held_;
};

}  // namespace mlcca
