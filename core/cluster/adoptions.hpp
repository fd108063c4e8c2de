// SPDX-License-Identifier: BSD-2-Clause
// The part of this gateway in admissions of other gateways on whose way it is, and to which it must
// agree.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/cluster/chain.hpp"
#include "core/cluster/fair_queue.hpp"
#include "core/cluster/view.hpp"

namespace mlcca::core::cluster {

/// Reports such admissions as events (Adopt, Opened, Ended) and sends this gateway's votes.
class Adoptions {
 public:
  explicit Adoptions(std::size_t self) : self_(self) {}

  /// Acts on what has changed since the last call.
  void step(View& view, bool joined, std::vector<Event>& events);
  /// Changes the vote on an adopted admission: this gateway cannot keep it any more, or now can.
  void vote(const Origin& origin, Vote vote, View& view, std::vector<Event>& events);
  /// Takes the result of a transaction with a vote.
  void on_done(const Done& done, const View& view);
  /// The membership is lost; the caller has closed everything.
  void lose(View& view);
  /// The next votes that the store does not contain yet, all on admissions of one gateway, so that
  /// only that gateway can make the transaction conflict. Gateways take turns. Nullopt: there are
  /// none. What is returned is taken as sent.
  [[nodiscard]] std::optional<Work> next_work(const View& view, const Codec& codec);
  /// Deletes own votes on admissions that no longer exist. The view must contain all own
  /// transactions.
  [[nodiscard]] std::optional<Work> clean_up(const View& view) const;

  /// Visits all state that affects its behaviour, for the model checker.
  template <class Visit>
  void visit_state(Visit&& visit) const {
    visit(adopted_, to_send_);
  }

 private:
  struct Adopted {
    std::int64_t asked = 0;  ///< see Origin
    std::optional<Vote> vote;
    std::uint64_t number = 0;  ///< number of the vote
    std::uint64_t stored = 0;  ///< number of the vote that the store contains
    bool opened = false;
    template <class Visit>
    void visit_state(Visit&& visit) const {
      visit(asked, vote, number, stored, opened);
    }
  };

  [[nodiscard]] const AskedRecord* live(const View& view, const Records::AskedKey& key) const;
  void take_up(const Records::AskedKey& key, View& view, std::vector<Event>& events);
  void open(const Records::AskedKey& key, const View& view, std::vector<Event>& events);
  void note_stored(const Work::Answer& answer, std::size_t gateway);

  std::size_t self_;
  std::map<Records::AskedKey, Adopted> adopted_;
  FairQueue to_send_;  ///< those with a vote that the store does not contain yet
};

}  // namespace mlcca::core::cluster
