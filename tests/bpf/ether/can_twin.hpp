// SPDX-License-Identifier: BSD-2-Clause
// A real CAN gate that obeys the same control word as a loaded Ethernet gate.
#pragma once
#include <memory>
#include <vector>

#include "daemon/gates/slots.hpp"

struct gate_test_bpf;

namespace mlcca::test {

class CanTwin {
 public:
  explicit CanTwin(int control_map);
  /// What comes in by this 11-bit identifier.
  static gates::SlotSpec slot(std::uint32_t id, bool pass);
  void admit(const std::vector<gates::SlotSpec>& specs);
  [[nodiscard]] bool passes(std::uint32_t id) const;
  [[nodiscard]] gates::SlotTable& table() { return *table_; }

 private:
  std::unique_ptr<gate_test_bpf, void (*)(gate_test_bpf*)> object_;
  std::unique_ptr<gates::SlotTable> table_;
};

}  // namespace mlcca::test
