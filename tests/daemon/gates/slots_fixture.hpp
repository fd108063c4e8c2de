// SPDX-License-Identifier: BSD-2-Clause
// A slot table on plain memory, and slots to put into it.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "daemon/gates/slots.hpp"

namespace mlcca::gates {

inline constexpr std::uint32_t kStandard = CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_SFF_MASK;
inline constexpr std::uint32_t kExtended = CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_EFF_MASK;

inline SlotSpec raw(std::uint32_t id, std::uint32_t source = 0) {
  SlotSpec s;
  s.direction = Direction::egress;
  s.pass = true;
  s.id = id;
  s.mask = (id & CAN_EFF_FLAG) != 0 ? kExtended : kStandard;
  s.source = source;
  s.subject = 1;
  return s;
}

inline SlotSpec refused(SlotSpec s) {
  s.pass = false;
  return s;
}

inline SlotChanges adding(std::vector<SlotSpec> specs) {
  SlotChanges changes;
  changes.add = std::move(specs);
  return changes;
}
inline SlotChanges removing(std::vector<SlotSpec> specs) {
  SlotChanges changes;
  changes.remove = std::move(specs);
  return changes;
}

inline std::vector<SlotSpec> sorted(std::vector<SlotSpec> specs) {
  std::ranges::sort(specs, {}, [](const SlotSpec& s) {
    return std::tuple(s.direction, s.id, s.mask, s.source, s.uid, s.origin, s.max_len, s.formats,
                      s.subject, s.pass);
  });
  return specs;
}

/// Identifiers of 29 bits that fall into one bucket.
inline std::vector<std::uint32_t> colliding(std::size_t count) {
  std::vector<std::uint32_t> ids;
  const std::uint32_t bucket = gate_bucket(GATE_PROFILE_RAW, CAN_EFF_FLAG);
  for (std::uint32_t id = CAN_EFF_FLAG; ids.size() < count; ++id)
    if (gate_bucket(GATE_PROFILE_RAW, id) == bucket) ids.push_back(id);
  return ids;
}

class Slots : public ::testing::Test {
 protected:
  SlotTable read(bool fresh = true, std::uint32_t profile = GATE_PROFILE_RAW) {
    auto table = SlotTable::read({*memory_, {cpus_.get(), 2}, generation_}, profile, fresh, [this] {
      ++waits_;
      return wait_result_;
    });
    EXPECT_TRUE(table) << table.error().text;
    return std::move(*table);
  }
  static std::string error(SlotTable& slots, const SlotChanges& changes) {
    const auto before = slots.present();
    const auto result = slots.apply(changes);
    EXPECT_EQ(slots.present(), before);
    return result ? "" : result.error().text;
  }

  /// Of a slot that no step is halfway through.
  [[nodiscard]] unsigned verdict_of(std::uint32_t slot) const {
    const auto& verdict = memory_->slots[slot].verdict;
    EXPECT_EQ(verdict[0], verdict[1]);
    return verdict[generation_ & 1];
  }

  std::uint32_t generation_ = 0;
  std::unique_ptr<gate_table> memory_ = std::make_unique<gate_table>();
  std::unique_ptr<gate_cpu[]> cpus_ = std::make_unique<gate_cpu[]>(2);
  int waits_ = 0;
  Result<void> wait_result_;
};

}  // namespace mlcca::gates
