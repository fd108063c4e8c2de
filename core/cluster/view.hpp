// SPDX-License-Identifier: BSD-2-Clause
// What one gateway knows of the store and of the other gateways: what they hold, and whether they
// may still send. Times are of the clock of this gateway, in ns, never going back.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/admission/holders.hpp"
#include "core/cluster/records.hpp"

namespace mlcca::core::cluster {

class View {
 public:
  View(std::shared_ptr<const Keys> keys, const Codec& codec, std::size_t self);

  /// Everything follows in apply(), and counts from end_snapshot() on. What is known of the time of
  /// others' beats stays, where these are still the last ones.
  void begin_snapshot(std::int64_t revision);
  void apply(const Batch& batch, Value now);
  void end_snapshot(Value now);
  void on_time(Value now);

  [[nodiscard]] bool complete() const { return complete_; }
  /// A snapshot was older than what had been seen. Stays until forget_going_back().
  [[nodiscard]] bool went_back() const { return went_back_; }
  void forget_going_back() { went_back_ = false; }
  [[nodiscard]] std::int64_t revision() const { return revision_; }
  [[nodiscard]] std::int64_t version(std::size_t network) const {
    return records_.versions[network];
  }
  [[nodiscard]] const Records& records() const { return records_; }
  [[nodiscard]] const Keys& keys() const { return *keys_; }

  /// What the others hold: those that are dead, too, as long as they or a gateway on their way may
  /// still send.
  [[nodiscard]] Foreign foreign(std::size_t network) const;
  /// The same with what is decided here as well.
  [[nodiscard]] Foreign of_others(std::size_t network) const;
  /// Which of the other gateways have reserved something there for others.
  [[nodiscard]] std::map<std::size_t, MadeFor> made_for(std::size_t network) const;
  /// An admission of another gateway is decided here as well, so it is not foreign.
  void adopt(std::size_t gateway, std::uint64_t id, bool adopted);

  [[nodiscard]] Alive alive(std::size_t gateway, Value now) const;
  /// Why the gateway cannot decide at present, with its name; empty: it can.
  [[nodiscard]] std::string absence(std::size_t gateway, Value now) const;
  /// A gateway was fenced and has not joined since.
  [[nodiscard]] bool is_fenced(std::size_t gateway) const;
  /// When its latest beat was seen; nullopt: it is not there.
  [[nodiscard]] std::optional<Value> seen_at(std::size_t gateway) const;
  /// It may send until then, by what was seen of its beats.
  [[nodiscard]] Value counts_until(std::size_t gateway) const {
    return timers_[gateway].counts_until;
  }
  /// A gateway may be fenced from then on; nullopt: it is not there, or it is fenced.
  [[nodiscard]] std::optional<Value> fence_from(std::size_t gateway) const;
  /// Of one in Records::left: it is dead, and so is all that the store has of it.
  [[nodiscard]] bool is_over(const std::string& gateway, Value now) const;
  /// It has closed what ended at `revision`: it says so, or it is gone or dead.
  [[nodiscard]] bool surely_closed(std::size_t gateway, std::int64_t revision, Value now) const;
  /// When nobody who is known now can hold anything any more by what was committed before now.
  [[nodiscard]] Value all_leases_end(Value now, Value own_lease) const;
  /// The longest lease for which another gateway counts that the store knows, or `own_lease`.
  [[nodiscard]] Value longest_lease(Value own_lease) const;
  /// Waits for these leases, as they are now. A longer one than a gateway may have counts as the
  /// longest that it may have once its entry is deleted or replaced by a beat.
  void await_leases(Value now, Value own_lease);
  /// When the leases end for which await_leases() waits; 0: it was not called.
  [[nodiscard]] Value leases_end() const { return leases_end_; }
  /// The longest of these leases, ns, as far as it may be.
  [[nodiscard]] Value longest_awaited() const { return longest_awaited_; }
  /// Another gateway whose beat cannot be read, so that it counts for the longest lease; nullopt:
  /// there is none.
  [[nodiscard]] std::optional<std::size_t> with_unread_beat() const;
  /// Another gateway that states a longer lease than it may have; nullopt: none does.
  [[nodiscard]] std::optional<std::size_t> with_too_long_lease() const;
  /// The lease for which a gateway counts.
  [[nodiscard]] Value lease(std::size_t gateway) const { return timers_[gateway].lease; }
  /// When time alone changes something; nullopt: never.
  [[nodiscard]] std::optional<Value> next_event(Value now) const;

  /// Networks whose foreign() may have changed.
  [[nodiscard]] std::vector<std::size_t> take_changed();
  /// Admissions that another gateway asks for, or has asked for, and that may have changed.
  [[nodiscard]] std::set<Records::AskedKey> take_touched();
  /// They all count as changed once more.
  void touch_asked();

  /// All that it acts on, for a checker.
  template <class Visit>
  void visit_state(Visit&& visit) const {
    visit(records_, coming_, parts_, timers_, dying_, adopted_, revision_, coming_revision_,
          complete_, snapshot_, went_back_, changed_, touched_, leases_end_, lawful_end_);
  }

 private:
  /// What the clock says of another gateway.
  struct Timer {
    std::int64_t mod = 0, fence = 0;  ///< to which it refers
    Value lease = kMostLease;         ///< of the last beat, also one with a lease that is refused
    bool drained = false;             ///< that was the last one
    Value counts_until = 0;           ///< it may send until then
    Value lawful_until = 0;           ///< the same if no lease is above kMostLease
    Value dead_at = 0;                ///< what was written before the fence ends then
    Value seen = 0;                   ///< only to be reported
    template <class Visit>
    void visit_state(Visit&& visit) const {
      visit(mod, fence, lease, drained, counts_until, lawful_until, dead_at);
    }
  };

  void take_in(const Entry& entry, Value now);
  static void time_beat(const MemberRecord& record, Timer& timer, Value now);
  static bool time_record(const MemberRecord& record, Timer& timer, Value now);
  void time_member(std::size_t gateway, Value now);
  void time_left(std::string_view gateway, Value now);
  void expire_left(Value now);
  void collect(Foreign& all, std::size_t network, std::size_t gateway, bool adopted_too) const;
  [[nodiscard]] std::vector<std::size_t> others_on(std::size_t network) const;
  using OfGateways = std::map<std::size_t, std::shared_ptr<const Foreign>>;
  const OfGateways& find_foreign(std::size_t network) const;
  void touch_reservation(std::size_t network, std::size_t gateway);
  void touch_all();
  void touch_those_of(std::size_t gateway);
  void expire(Value now);
  [[nodiscard]] bool is_over(const Records::ReservationKey& key, ReservationRecord& record,
                             Value now) const;

  std::shared_ptr<const Keys> keys_;
  const Codec* codec_;
  std::size_t self_;
  Records records_, coming_;
  std::vector<Entry> parts_;  ///< of a revision that is not complete
  std::vector<Timer> timers_;
  std::map<std::string, Timer, std::less<>> left_timers_;  ///< of gateways in Records::left
  std::set<std::size_t> dying_;  ///< that may have something from before their fence
  std::set<Records::AskedKey> adopted_;
  std::int64_t revision_ = 0, coming_revision_ = 0;
  bool complete_ = false, snapshot_ = false, went_back_ = false;
  std::set<std::size_t> changed_;
  std::set<Records::AskedKey> touched_;
  Value leases_end_ = 0, lawful_end_ = 0;  ///< see await_leases()
  Value longest_awaited_ = 0;              ///< the same as a lease, for texts

  /// What foreign() has found, by network, of each gateway that has something there; null: it may
  /// have something else since. Of many gateways one changes at a time.
  mutable std::map<std::size_t, OfGateways> found_;
};

}  // namespace mlcca::core::cluster
