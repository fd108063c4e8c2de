// SPDX-License-Identifier: BSD-2-Clause
// The messages of every analysed CAN bus as the design-time check decides them: granted ones, and
// those that were tried and refused.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "core/admission/admission.hpp"
#include "core/can/analysis.hpp"
#include "core/can/message.hpp"
#include "core/model/verdict.hpp"
#include "core/reserve/ledger.hpp"

namespace mlcca::core {

/// The frames of one publisher on one bus, arriving from one place.
struct BusMessage {
  std::size_t network = 0;
  std::size_t publisher = 0;
  std::size_t from = Flow::kOwn;  ///< see Flow::from
  /// With the jitter of the route so far and the deadline left for this bus; nullopt if the
  /// description is not sufficient.
  std::optional<can::Message> message;
  /// The same with the jitter that results from the messages that count; if it is held, with the
  /// deadline of that alone.
  std::optional<can::Message> sent;
  std::size_t set = 0;  ///< index of the attribute set
  /// The worst outcome for the places behind the bus that events may reach. Fit: granted with
  /// certainty to all of these. Unfit: granted to none.
  Outcome outcome = Outcome::fit;
  bool held = false;     ///< granted to at least one place if best cases hold, so that the ledger
                         ///< holds it
  bool present = false;  ///< on the bus if all best cases hold: held, or sent there although
                         ///< refused
  /// If it is granted: its response (as of Schedule, kNever if not bounded) and its jitter, with
  /// only granted messages on the buses.
  std::optional<Value> granted_response;
  Value granted_jitter = 0;
  /// If the check refuses it because it would be late: the response that the check found among what
  /// was granted before (kNever if not bounded), and its jitter.
  std::optional<Value> refused_response;
  Value refused_jitter = 0;
  /// If the check refuses it because its queue could lose frames: how many wait there.
  std::optional<std::uint32_t> refused_frames;
  bool in_vain = false;  ///< refused because something would be late or lost on this bus
  bool several = false;  ///< for several places behind the bus, which are decided separately
  /// Hops before the bus with an unknown delay. They count as if they had none.
  std::vector<Place> unknown;
  /// With unknown hops: the longest jitter with which it can be granted; kNever: unlimited.
  can::Time most_jitter = 0;
  /// The bus before this one, and what the hops in between may add to the jitter.
  struct Before {
    std::size_t network = 0;
    std::size_t from = Flow::kOwn;
    Value added = 0;  ///< ns
  };
  std::optional<Before> before;

  /// Whether it can be on the bus, if need be at run time in the place of others.
  [[nodiscard]] bool is_counted() const { return present || outcome == Outcome::run_time; }
};

/// What is on the analysed buses. All vectors except `messages` are indexed by network.
struct InspectedBuses {
  std::vector<std::optional<can::Assumptions>> assumptions;  ///< nullopt: not analysed
  std::vector<BusMessage> messages;                          ///< sorted by network, then publisher
  /// Nothing can be there that admission did not find in time together with all others. So what is
  /// granted is in time whatever holds at run time.
  std::vector<bool> guarded;
  /// Nothing can be there except for the messages above in exactly these forms.
  std::vector<bool> all_known;
  /// Like all_known, except for BusMessage::most_jitter: only delays are unknown.
  std::vector<bool> forms_known;
  /// Channels that may use another attribute set or route than the messages above.
  std::vector<std::vector<std::size_t>> varying;
};

/// Sets the jitter of refused messages to what they would have: as late as the bus before makes
/// them, in `message` with all messages on all buses, in `sent` with those that count; can::kNever
/// if not bounded there. If everything is granted nothing changes, because granted messages are in
/// time everywhere. Also computes guarded, all_known and forms_known. On entry all else is set,
/// with the messages in the order of BusMessages::take().
void inherit_jitter(InspectedBuses& buses);

/// Collects the messages of all analysed buses during a check.
class BusMessages {
 public:
  /// Adds the final verdicts of a channel.
  void add(const Situation& situation, const Ledger& ledger, const Decision& decision);

  /// Adds only the verdicts that may be granted in the place of others.
  void add_contested(const Decision& decision);

  /// Returns the messages, sorted by network and publisher, when everything is decided. The ledger
  /// is used and left unchanged.
  [[nodiscard]] std::vector<BusMessage> take(const Situation& situation, Ledger& ledger);

 private:
  void add(const Situation& situation, const Ledger& ledger, const Verdict& verdict);
  void add_refused(const Situation& situation, Ledger& ledger, Verdict verdict);
  void put(BusMessage next);
  void take_granted(const Ledger& ledger);

  std::vector<BusMessage> messages_;
  /// Indices into messages_, by network, publisher and `from`.
  std::map<std::tuple<std::size_t, std::size_t, std::size_t>, std::size_t> known_;
  std::vector<Verdict> refused_;
};

}  // namespace mlcca::core
