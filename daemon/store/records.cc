// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/store/records.hpp"

#include <limits>
#include <utility>

#include "control/protobuf.hpp"
#include "daemon/store/fields.hpp"

namespace mlcca::store {
namespace {

using gates::Direction;
using gates::PlacedSlot;
using gates::SlotSpec;

// If SlotSpec gets another field, its record needs it as well.
static_assert(sizeof(SlotSpec) == 104);

Slot record_of(const PlacedSlot& placed) {
  const SlotSpec& s = placed.slot;
  Slot slot{.ifindex = placed.ifindex,
            .egress = s.direction == Direction::egress,
            .passes = s.pass,
            .excess_passes = s.excess_passes,
            .max_length = s.max_len,
            .formats = s.formats,
            .id = s.id,
            .mask = s.mask,
            .source = s.source,
            .origin = s.origin,
            .station = s.station,
            .per_frame = s.per_frame,
            .per_byte = s.per_byte,
            .tolerance = s.tolerance,
            .period = s.period,
            .silence = s.silence,
            .together = s.together};
  if (s.uid != GATE_ANY_UID) slot.user = s.uid;
  return slot;
}

std::optional<PlacedSlot> slot_in(const Slot& slot, std::uint64_t subject) {
  PlacedSlot placed;
  SlotSpec& s = placed.slot;
  if (slot.max_length > std::numeric_limits<decltype(s.max_len)>::max() ||
      slot.formats > std::numeric_limits<decltype(s.formats)>::max())
    return std::nullopt;
  placed.ifindex = slot.ifindex;
  s.direction = slot.egress ? Direction::egress : Direction::ingress;
  s.pass = slot.passes;
  s.excess_passes = slot.excess_passes;
  s.max_len = static_cast<std::uint16_t>(slot.max_length);
  s.formats = static_cast<std::uint8_t>(slot.formats);
  s.id = slot.id;
  s.mask = slot.mask;
  s.source = slot.source;
  s.uid = slot.user.value_or(GATE_ANY_UID);
  s.origin = slot.origin;
  s.station = slot.station;
  s.subject = subject;
  s.per_frame = slot.per_frame;
  s.per_byte = slot.per_byte;
  s.tolerance = slot.tolerance;
  s.period = slot.period;
  s.silence = slot.silence;
  s.together = slot.together;
  return placed;
}

}  // namespace

std::string record_of(const core::Grants& grants) {
  if (grants.deliveries.empty()) return {};
  Grants message{grants.set, {}};
  for (const core::Delivery& d : grants.deliveries)
    message.deliveries.push_back({d.publisher, d.admission, d.to});
  return control::bytes_of(message);
}

std::optional<core::Grants> grants_in(std::string_view record) {
  auto message = control::message_in<Grants>(record);
  if (!message) return std::nullopt;
  core::Grants grants{static_cast<std::size_t>(message->set), {}};
  for (Delivery& d : message->deliveries)
    grants.deliveries.push_back({std::move(d.publisher), d.admission, std::move(d.to)});
  return grants;
}

std::string record_of(std::span<const PlacedSlot> slots) {
  Slots message;
  for (const PlacedSlot& placed : slots) message.slots.push_back(record_of(placed));
  return control::bytes_of(message);
}

std::optional<std::vector<PlacedSlot>> slots_in(std::string_view record, std::uint64_t subject) {
  const auto message = control::message_in<Slots>(record);
  if (!message) return std::nullopt;
  std::vector<PlacedSlot> slots;
  for (const Slot& slot : message->slots) {
    const auto placed = slot_in(slot, subject);
    if (!placed) return std::nullopt;
    slots.push_back(*placed);
  }
  return slots;
}

}  // namespace mlcca::store
