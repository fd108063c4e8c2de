// SPDX-License-Identifier: BSD-2-Clause
// What a CAN interface gets before there is a daemon, loaded but not attached.
#pragma once
#include <memory>

#include "tests/bpf/loaded_gate.hpp"

struct gate_closed_test_bpf;

namespace mlcca::test {

class ClosedGate {
 public:
  /// Aborts the test program where the kernel refuses the object.
  explicit ClosedGate(int control_map);
  [[nodiscard]] bool drops(gates::Direction direction, const Bytes& bytes,
                           const Sender& sender) const;

 private:
  std::unique_ptr<gate_closed_test_bpf, void (*)(gate_closed_test_bpf*)> object_;
};

}  // namespace mlcca::test
