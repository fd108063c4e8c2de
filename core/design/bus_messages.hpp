// SPDX-License-Identifier: BSD-2-Clause
// The messages of every analysed CAN bus as a check of the description decides them: those that are
// granted, and those that were tried in vain.
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

/// The frames of one publisher on one bus, coming from one place.
struct BusMessage {
  std::size_t network = 0;
  std::size_t publisher = 0;
  std::size_t from = Flow::kOwn;  ///< as of Flow
  /// With the jitter of the way so far and the deadline that is left for this bus; nothing where
  /// the description does not say enough.
  std::optional<can::Message> message;
  /// The same with the jitter that it has beside what counts there, and of what is held the
  /// deadline of that alone.
  std::optional<can::Message> sent;
  std::size_t set = 0;  ///< attribute set
  /// The worst of what is decided about those behind the bus to whom anything may come: fit is
  /// granted with certainty, to all of these. Unfit: it is granted to nobody.
  Outcome outcome = Outcome::fit;
  bool held = false;     ///< granted to somebody, at best perhaps: the ledger holds it
  bool present = false;  ///< on the bus if all best cases hold: held, or sent there though refused
  /// With nothing on the buses but what is granted, if this is: as of Schedule, kNever if not
  /// bounded, and the jitter with it.
  std::optional<Value> granted_response;
  Value granted_jitter = 0;
  /// Where a check refuses it because it would be late itself: the response time that the check
  /// found, with what was granted before it; kNever if not bounded. And the jitter with it.
  std::optional<Value> refused_response;
  Value refused_jitter = 0;
  /// Where a check refuses it because frames could be lost in its queue: how many wait there.
  std::optional<std::uint32_t> refused_frames;
  bool in_vain = false;  ///< refused because something would be late or lost on this bus
  bool several = false;  ///< for several places behind the bus, each decided for itself
  /// Hops before the bus of which nobody knows how long they delay events: they count as none.
  std::vector<Place> unknown;
  /// Where there are any: the longest jitter with which it can be granted; kNever: no bound.
  can::Time most_jitter = 0;
  /// The bus before this one, and what the hops in between may add to the jitter.
  struct Before {
    std::size_t network = 0;
    std::size_t from = Flow::kOwn;
    Value added = 0;  ///< ns
  };
  std::optional<Before> before;

  /// It can be on the bus, at run time perhaps in the place of others.
  [[nodiscard]] bool is_counted() const { return present || outcome == Outcome::run_time; }
};

/// What is on the analysed buses. Vectors by network.
struct InspectedBuses {
  std::vector<std::optional<can::Assumptions>> assumptions;  ///< where analysed
  std::vector<BusMessage> messages;                          ///< by network, then publisher
  /// Nothing can be there that admission did not find in time with all others: so what is granted
  /// is in time, whatever holds at run time.
  std::vector<bool> guarded;
  /// Nothing can be there in another form than that of the messages above.
  std::vector<bool> all_known;
  /// The same but for BusMessage::most_jitter: nothing but delays is not known.
  std::vector<bool> forms_known;
  /// Channels that may use another attribute set or way than the messages above have.
  std::vector<std::vector<std::size_t>> varying;
};

/// Makes the jitter of what is refused that which it would have: as late as the bus before lets it
/// be, in `message` with all messages on all buses, in `sent` with those that count. Whatever is
/// granted is in time everywhere, so if everything is nothing changes. Not bounded there:
/// can::kNever. Finds out which buses are guarded, and of which all is known. `buses` has all else,
/// messages in the order of BusMessages::take().
void inherit_jitter(InspectedBuses& buses);

class BusMessages {
 public:
  /// All verdicts of a channel as they were decided in the end.
  void add(const Situation& situation, const Ledger& ledger, const Decision& decision);

  /// Those alone that may be granted in the place of others.
  void add_contested(const Decision& decision);

  /// When everything is decided. `ledger` is left as it was. In the order of networks and
  /// publishers.
  [[nodiscard]] std::vector<BusMessage> take(const Situation& situation, Ledger& ledger);

 private:
  void add(const Situation& situation, const Ledger& ledger, const Verdict& verdict);
  void add_refused(const Situation& situation, Ledger& ledger, Verdict verdict);
  void put(BusMessage next);
  void take_granted(const Ledger& ledger);

  std::vector<BusMessage> messages_;
  /// Their places, by network, publisher and from.
  std::map<std::tuple<std::size_t, std::size_t, std::size_t>, std::size_t> known_;
  std::vector<Verdict> refused_;
};

}  // namespace mlcca::core
