// SPDX-License-Identifier: BSD-2-Clause
#include "core/design/findings.hpp"

#include <algorithm>
#include <array>

namespace mlcca::core {
namespace {

using Id = FindingId;
using S = Severity;

constexpr auto kTable = std::to_array<FindingInfo>({
    {Id::unreadable, S::error, "unreadable", "a file cannot be read"},
    {Id::not_xml, S::error, "not-xml", "a file is not XML that we read"},
    {Id::not_in_schema, S::error, "not-in-schema",
     "an element, attribute or value is not in the schema"},
    {Id::rule, S::error, "rule", "a rule of the description is broken"},
    {Id::unknown_name, S::error, "unknown-name", "a name is used that nothing has"},
    {Id::name_twice, S::error, "name-twice", "two things have the same name"},
    {Id::wrong_place, S::error, "wrong-place", "something is said where it has no meaning"},
    {Id::too_many, S::error, "too-many", "a limit is exceeded"},
    {Id::subject_twice, S::error, "subject-twice", "two channels have the same subject"},
    {Id::no_publisher, S::error, "no-publisher", "a subscription has no publisher"},
    {Id::unused_publisher, S::warning, "unused-publisher", "nobody subscribes what is published"},
    {Id::unused_channel, S::note, "unused-channel",
     "a channel has neither publisher nor subscriber"},
    {Id::no_route, S::error, "no-route", "no way leads from a publisher to a subscriber"},
    {Id::unreachable_network, S::warning, "unreachable-network",
     "no gateway has a port on a network"},
    {Id::identifier_clash, S::error, "identifier-clash",
     "an identifier or a binding is given twice on a network"},
    {Id::interface_twice, S::error, "interface-twice", "two ports claim the same interface"},
    {Id::unbound, S::error, "unbound", "a channel has no identifier on a CAN network on its way"},
    {Id::sender_twice, S::error, "sender-twice", "two publishers cannot be told apart"},
    {Id::unplaced, S::error, "unplaced", "a component has no place, or two"},
    {Id::traffic_mismatch, S::error, "traffic-mismatch",
     "a publisher does not offer what a subscriber asks"},
    {Id::hop_unfit, S::error, "hop-unfit", "a network or gateway does not fulfil a requirement"},
    {Id::route_unfit, S::error, "route-unfit", "the way as a whole does not fulfil a requirement"},
    {Id::overhearing_unfit, S::error, "overhearing-unfit",
     "others who hear the events on a shared medium are not fulfilled"},
    {Id::capacity, S::error, "capacity", "a network cannot carry all of its channels together"},
    {Id::too_long, S::error, "too-long", "events do not fit the frames of a network"},
    {Id::no_node, S::error, "no-node", "a publisher states no node where one is needed"},
    {Id::no_traffic, S::error, "no-traffic",
     "a publisher does not say what it sends where capacity is shared"},
    {Id::run_time, S::note, "run-time", "best cases do not refute it: decided at run time"},
    {Id::lower_set, S::note, "lower-set",
     "a preferred attribute set does not fit, a lower one does"},
    {Id::unsafe_drop, S::warning, "unsafe-drop",
     "events that must arrive cross a gate, which drops when in doubt"},
    {Id::deadline_missed, S::error, "deadline-missed", "a message on a CAN bus can come too late"},
    {Id::medium_time, S::error, "medium-time",
     "the links of a mesh have not enough time left for a channel"},
    {Id::shared_limit, S::warning, "shared-limit",
     "publishers look alike to a gate and share what was admitted"},
    {Id::not_decided, S::note, "not-decided",
     "what a network gives must be computed, which the stylesheet cannot"},
    {Id::no_data_rate, S::error, "no-data-rate",
     "FD frames on a bus that has no bit rate for their data phase"},
    {Id::queue_too_short, S::error, "queue-too-short",
     "the queue of a gateway is too short for the frames that may wait in it"},
    {Id::relay_gated, S::warning, "relay-gated",
     "the gate of a port drops what its node relays for others"},
    {Id::no_omission, S::note, "no-omission",
     "nobody says how many heart-beats in a row may be lost"},
    {Id::long_period, S::note, "long-period",
     "an hour or more lies between the events of a channel on which safety depends"},
    {Id::managed_in_vain, S::note, "managed-in-vain",
     "a port is managed on a network that is no CAN network"},
    {Id::unstarted_sender, S::note, "unstarted-sender",
     "a program carries events, and mlccad does not start it"},
});

constexpr bool is_dense() {
  for (std::size_t i = 0; i < kTable.size(); ++i)
    if (static_cast<std::size_t>(kTable[i].id) != i + 1) return false;
  return true;
}
static_assert(is_dense());

}  // namespace

std::span<const FindingInfo> finding_table() { return kTable; }

const FindingInfo& info(FindingId id) { return kTable[static_cast<std::size_t>(id) - 1]; }

std::string code_of(FindingId id) {
  auto digits = std::to_string(static_cast<unsigned>(id));
  return "MLCCA" + std::string(3 - std::min<std::size_t>(3, digits.size()), '0') + digits;
}

}  // namespace mlcca::core
