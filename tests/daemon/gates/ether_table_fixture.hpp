// SPDX-License-Identifier: BSD-2-Clause
// A table of an Ethernet gate in plain memory.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "daemon/gates/ether_table.hpp"

namespace mlcca::gates {

inline SlotSpec slot(std::uint64_t subject, bool pass = true) {
  SlotSpec s;
  s.direction = Direction::ingress;
  s.pass = pass;
  s.subject = subject;
  s.formats = ETHER_UNFRAGMENTED;
  return s;
}

inline SlotChanges adding(std::vector<SlotSpec> specs) {
  SlotChanges c;
  c.add = std::move(specs);
  return c;
}
inline SlotChanges removing(std::vector<SlotSpec> specs) {
  SlotChanges c;
  c.remove = std::move(specs);
  return c;
}

class EtherTableTest : public ::testing::Test {
 protected:
  explicit EtherTableTest(const EtherSizes& sizes = EtherSizes::for_slots(0, 2))
      : sizes_(sizes),
        buckets_(sizes.buckets),
        prefilters_(sizes.prefilters()),
        slots_(sizes.slots),
        contracts_(sizes.contracts),
        counts_(std::size_t{sizes.banks} * sizes.slots),
        table_(open(true).value()) {}

  Result<EtherTable> open(bool fresh) {
    return EtherTable::read({&head_, buckets_, prefilters_, slots_, contracts_, counts_, audits_,
                             watches_, &generation_},
                            sizes_, fresh, 42, [this]() -> Result<void> {
                              ++waits_;
                              if (!grace_) return fail("no grace");
                              return {};
                            });
  }
  Result<void> add(const std::vector<SlotSpec>& specs) { return table_.apply(adding(specs)); }
  Result<void> remove(const std::vector<SlotSpec>& specs) { return table_.apply(removing(specs)); }
  [[nodiscard]] bool passes(const SlotSpec& s) const {
    return slots_[table_.find(s).value()].verdict[generation_ & 1] == GATE_PASS;
  }
  [[nodiscard]] std::vector<SlotSpec> present() const { return sorted(table_.present()); }
  static std::vector<SlotSpec> sorted(std::vector<SlotSpec> specs) {
    std::ranges::sort(specs, [](const SlotSpec& a, const SlotSpec& b) {
      return std::tie(a.subject, a.station, a.source, a.uid, a.max_len) <
             std::tie(b.subject, b.station, b.source, b.uid, b.max_len);
    });
    return specs;
  }
  std::string error_of(const Result<void>& done) { return done ? "" : done.error().text; }

  EtherSizes sizes_;
  int waits_ = 0;
  bool grace_ = true;
  std::uint32_t generation_ = 0;
  ether_table head_{};
  std::vector<std::uint64_t> buckets_;
  std::vector<ether_prefilter_part> prefilters_;
  std::vector<ether_slot> slots_;
  std::vector<ether_contract> contracts_;
  std::vector<gate_count> counts_;
  std::vector<gate_audit> audits_ = std::vector<gate_audit>(sizes_.slots);
  std::vector<gate_watch> watches_ = std::vector<gate_watch>(ETHER_WATCHES);
  EtherTable table_;
};

}  // namespace mlcca::gates
