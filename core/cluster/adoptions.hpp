// SPDX-License-Identifier: BSD-2-Clause
// The admissions of other gateways that this one must agree to, because it is on their way.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/cluster/chain.hpp"
#include "core/cluster/view.hpp"

namespace mlcca::core::cluster {

class Adoptions {
 public:
  explicit Adoptions(std::size_t self) : self_(self) {}

  /// Takes up what has changed since it joined.
  void step(View& view, bool joined, std::vector<Event>& events);
  /// Once more for the same admission: this one may not keep it any more, or can.
  void vote(const Origin& origin, Vote vote, View& view, std::vector<Event>& events);
  void on_done(const Done& done);
  /// Everything is closed already.
  void lose(View& view);
  [[nodiscard]] std::optional<Work> next_work(const View& view, const Codec& codec) const;
  /// Votes on what is no more, in a view that has all own transactions.
  [[nodiscard]] std::optional<Work> clean_up(const View& view) const;

  /// All that it acts on, for a checker.
  template <class Visit>
  void visit_state(Visit&& visit) const {
    visit(adopted_);
  }

 private:
  struct Adopted {
    std::int64_t asked = 0;  ///< see Origin
    std::optional<Vote> vote;
    std::uint64_t number = 0;  ///< of the vote
    std::uint64_t stored = 0;  ///< number of the vote that the store has
    bool opened = false;
    template <class Visit>
    void visit_state(Visit&& visit) const {
      visit(asked, vote, number, stored, opened);
    }
  };

  [[nodiscard]] const AskedRecord* live(const View& view, const Records::AskedKey& key) const;
  void take_up(const Records::AskedKey& key, View& view, std::vector<Event>& events);
  void open(const Records::AskedKey& key, const View& view, std::vector<Event>& events);

  std::size_t self_;
  std::map<Records::AskedKey, Adopted> adopted_;
};

}  // namespace mlcca::core::cluster
