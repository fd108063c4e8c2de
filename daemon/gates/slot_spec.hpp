// SPDX-License-Identifier: BSD-2-Clause
// The content of one slot of a gate, and the changes of the slots of an interface.
#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "bpf/gate.h"
#include "core/gates/direction.hpp"

namespace mlcca::gates {

using core::Direction;
static_assert(std::to_underlying(Direction::ingress) == GATE_INGRESS &&
              std::to_underlying(Direction::egress) == GATE_EGRESS);

/// What one slot admits. A frame fits if (can_id & mask) == id, with the flags of <linux/can.h>.
/// The key of the slot is what the profile makes the subject: gate_key_mask().
struct SlotSpec {
  Direction direction = Direction::ingress;
  bool pass = false;
  std::uint16_t max_len = 8;            ///< payload bytes; with GATE_TRANSPORT of a message
  std::uint8_t formats = GATE_CLASSIC;  ///< GATE_CLASSIC | GATE_FD | GATE_XL | GATE_TRANSPORT;
                                        ///< Ethernet: ETHER_*
  std::uint32_t id = 0;                 ///< with CAN_EFF_FLAG for 29 bits
  std::uint32_t mask = 0;               ///< has CAN_EFF_FLAG and the key (a masked slot: a part of
                                        ///< it); RTR unless declared
  std::uint32_t source = 0;             ///< egress: ifindex it entered by, 0: a local program,
                                        ///< GATE_NO_SOURCE: the kernel itself
  std::uint32_t uid = GATE_ANY_UID;     ///< local program's user
  std::uint32_t origin = 0;             ///< CAN, gate_has_origin(): see gate_origin()
  std::uint64_t station = 0;            ///< Ethernet: ether_station(), 0: the wildcard
  std::uint64_t subject = 0;
  // The traffic that passes, see gate_slot; all 0: not policed.
  std::uint64_t per_frame = 0;
  std::uint64_t per_byte = 0;
  std::uint64_t tolerance = 0;
  bool excess_passes = false;
  // How its events are expected, see gate_watch; all 0: not supervised.
  std::uint64_t period = 0;  ///< at most GATE_LONGEST_PERIOD
  std::uint64_t silence = 0;
  std::uint64_t together = 0;

  bool operator==(const SlotSpec&) const = default;
  /// Whether the same traffic is admitted and expected.
  [[nodiscard]] bool same_traffic(const SlotSpec& other) const;
  /// Whether both are equal except for the verdict and the traffic.
  [[nodiscard]] bool same_grant(const SlotSpec& other) const;
};

/// A slot with its interface.
struct PlacedSlot {
  std::uint32_t ifindex = 0;
  SlotSpec slot;
  bool operator==(const PlacedSlot&) const = default;
};

/// Changes of the slots of one interface. `close`, `remove` and `open` identify slots by everything
/// except the verdict and the traffic.
struct SlotChanges {
  std::vector<SlotSpec> close;
  std::vector<SlotSpec> add;  ///< passes after the change if `pass` is set
  std::vector<SlotSpec> remove;
  std::vector<SlotSpec> open;
  std::vector<SlotSpec> police;  ///< slots that stay, with their new traffic

  [[nodiscard]] bool empty() const {
    return close.empty() && add.empty() && remove.empty() && open.empty() && police.empty();
  }
};

/// Orders slots by everything except the verdict and the traffic.
struct ByGrant {
  bool operator()(const SlotSpec& a, const SlotSpec& b) const;
};

/// The changes that turn `present` into `wanted`. Slots that are in both with the same verdict are
/// not mentioned. What goes is denied in the same step in which what comes opens: see
/// VerdictTable::apply().
SlotChanges slot_changes_between(std::span<const SlotSpec> present,
                                 std::span<const SlotSpec> wanted);

/// Waits until no CPU runs a program that began before the call (one RCU grace period).
using GracePeriod = std::function<Result<void>()>;

}  // namespace mlcca::gates
