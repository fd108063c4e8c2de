// SPDX-License-Identifier: BSD-2-Clause
// The admissions that one gateway has asked for, from the request to the last trace in the store.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/cluster/chain.hpp"
#include "core/cluster/view.hpp"

namespace mlcca::core::cluster {

/// An admission as it was decided from the view of now. Numbers are not used again before the
/// former admission has left the store.
struct Wanted {
  std::uint64_t id = 0;
  Footprint footprint = {};
  std::string channel = {}, publisher = {};
  std::string admission = {};  ///< the caller's, for gateways on the way and for a restart
  /// The other gateway for which it is made; nothing: it is for nobody else.
  std::optional<std::size_t> made_for = std::nullopt;
};

class Admissions {
 public:
  /// Times that somebody else may be quicker, and how long an answer may take, ns.
  static constexpr unsigned kMostTries = 64;
  static constexpr Value kPatience = 3'000'000'000;
  /// After the first conflict an admission waits for a random time of at most this, after each
  /// further one for at most twice as long as before, ns: those who were in each other's way come
  /// one after the other then.
  static constexpr Value kFirstWait = 4'000'000;
  static constexpr Value kLongestWait = 64'000'000;

  /// `seed`: of these times, another one in each process. A checker has `first_wait` 0.
  Admissions(std::size_t self, std::uint64_t seed, Value first_wait)
      : self_(self), seed_(seed), first_wait_(first_wait) {}

  /// Another one than `id` waits for its answer and is to be decided again, has not been sent, or
  /// its answer is not known.
  [[nodiscard]] bool deciding(std::uint64_t id) const;
  [[nodiscard]] bool knows(std::uint64_t id) const { return own_.contains(id); }
  [[nodiscard]] bool empty() const { return own_.empty(); }
  [[nodiscard]] bool granted(std::uint64_t id) const;

  void reserve(Wanted wanted, const View& view, Value now, std::vector<Event>& events);
  void release(std::uint64_t id, Value now);
  /// Whoever waits for an answer is refused.
  void release_all(const std::string& why, Value now, std::vector<Event>& events);
  /// The caller closes what is granted, and releases it; whoever waits is refused.
  void withdraw_all(const std::string& why, Value now, std::vector<Event>& events);
  /// After a start or a new beginning, from a view that has all that was committed. What was
  /// granted from the revision `since` on still is; what is older counts for nobody and leaves the
  /// store.
  void find(const View& view, std::int64_t since, Value now, std::vector<Event>& events);
  /// Everything is lost; who waits is refused.
  void lose(const std::string& why, std::vector<Event>& events);

  void on_done(const Done& done, const View& view, Value now, std::vector<Event>& events);
  /// What votes, other gateways and time make of it.
  void step(const View& view, Value now, std::vector<Event>& events);
  /// Nothing new is taken where `may_take` is false.
  [[nodiscard]] std::optional<Work> next_work(const View& view, const Codec& codec, bool may_take,
                                              Value now);
  [[nodiscard]] std::optional<Value> next_time(Value now) const;

  /// All that it acts on, for a checker.
  template <class Visit>
  void visit_state(Visit&& visit) const {
    visit(own_, versions_);
  }

 private:
  enum class State : std::uint8_t {
    asked,     ///< to be sent, or sent
    decide,    ///< somebody was quicker: the caller decides again
    prepared,  ///< others vote
    opening,   ///< granted, others are to open
    granted,
    ending,   ///< others are to close
    erasing,  ///< nobody holds it: it is to leave the store when its last frame has left
  };
  struct Own {
    Wanted wanted = {};
    State state = State::asked;
    std::map<std::size_t, std::int64_t> versions = {};  ///< of networks, from which it was decided
    bool sent = false;                                  ///< asked: and what came of it is not known
    bool answered = false, given_up = false, withdrawn = false;
    Value since = 0;
    unsigned tries = 0;
    std::optional<Conflict> quicker = std::nullopt;  ///< to be reported
    std::int64_t seen = 0;                           ///< when the view has this revision
    Value again_at = 0;                              ///< and not before
    std::string taken_by = {};                       ///< the latest one that was quicker
    std::optional<std::size_t> taken_on = {};        ///< the network of which that one took
    std::int64_t opened = 0;                         ///< revision at which it was granted
    Value erase_from = 0;                            ///< nothing of it waits in a queue any more
    std::int64_t ended = 0;  ///< revision at which it was said to end; 0: not yet
    template <class Visit>
    void visit_state(Visit&& visit) const {
      visit(wanted.id, wanted.footprint, state, versions, sent, answered, given_up, withdrawn,
            since, tries, quicker, seen, again_at, opened, ended, erase_from);
    }
  };

  static void refuse(Own& own, Vote why, std::optional<std::size_t> by, std::vector<Event>& events);
  static void withdraw(Own& own, Vote why, std::optional<std::size_t> by,
                       std::vector<Event>& events);
  static bool nowhere_but_here(const Own& own);
  static void give_up(Own& own, Value now);
  static void erase(Own& own, Value now);
  void on_reserved(Own& own, const Done& done, Value now, std::vector<Event>& events);
  bool on_asked(Own& own, const Done& done, const View& view, Value now,
                std::vector<Event>& events);
  void on_quicker(Own& own, const Done& done, const View& view, Value now,
                  std::vector<Event>& events) const;
  void step_votes(Own& own, const View& view, Value now, std::vector<Event>& events) const;
  static void step_quicker(Own& own, const View& view, Value now, std::vector<Event>& events);
  static Vote taken_meanwhile(const Own& own, const View& view);
  void refuse_late(Own& own, const View& view, std::vector<Event>& events) const;
  [[nodiscard]] std::optional<std::size_t> silent_gateway(const Own& own, const View& view) const;
  [[nodiscard]] Value wait_of(const Own& own) const;
  [[nodiscard]] Work reservation(const Own& own, const View& view, const Codec& codec) const;
  [[nodiscard]] std::optional<Work> opening(const Own& own, const View& view,
                                            const Codec& codec) const;
  [[nodiscard]] Work ending(const Own& own, const View& view, const Codec& codec) const;
  [[nodiscard]] Work erasure(const Own& own, const View& view) const;
  [[nodiscard]] std::optional<Work> work_of(const Own& own, const View& view, const Codec& codec,
                                            bool may_take, Value now) const;

  std::size_t self_;
  std::uint64_t seed_;
  Value first_wait_;
  std::map<std::uint64_t, Own> own_;
  std::map<std::size_t, std::int64_t> versions_;  ///< that own transactions have made
};

}  // namespace mlcca::core::cluster
