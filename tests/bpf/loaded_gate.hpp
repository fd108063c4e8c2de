// SPDX-License-Identifier: BSD-2-Clause
// The real gate object, loaded but not attached, and frames run through it by BPF_PROG_TEST_RUN.
#pragma once
#include <linux/bpf.h>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "bpf/gate.h"
#include "daemon/gates/mapped.hpp"
#include "daemon/gates/slots.hpp"

struct bpf_test_run_opts;
struct gate_test_bpf;

namespace mlcca::test {

inline constexpr std::uint32_t kIfindex = 7;  ///< of the gate under test
inline constexpr std::uint32_t kOther = 9;    ///< another interface with a gate
inline constexpr std::uint32_t kToken = 0xa5c30f1e;
/// Mark of what only audit mode has passed at an ingress gate.
inline constexpr std::uint32_t kReportedBefore = ~kToken ^ 1U;

struct GateOptions {
  std::uint32_t profile = GATE_PROFILE_RAW;
  bool direct_access = true;
  bool echo_by_mark = false;
  bool atomic_counts = false;
  bool silent = false;

  auto operator<=>(const GateOptions&) const = default;
};

using Bytes = std::vector<std::uint8_t>;

/// A classic frame for up to 8 bytes when `fd` is false, else an FD frame. `length` may be wrong.
Bytes frame(std::uint32_t can_id, unsigned length, bool fd = false);

/// A CAN XL frame of `length` payload bytes behind `lead` bytes of a driver's private data, which
/// are 0. `id`: the word with the priority.
Bytes xl_frame(std::uint32_t id, unsigned length, std::size_t lead = 0);

struct Sender {
  bool local = false;  ///< a program of user 0
  std::uint32_t mark = 0;
  std::uint32_t ingress_ifindex = 0;
  bool xl = false;  ///< the kernel says that it is a CAN XL frame
};

/// skb->priority, which says it to the program: see test_skb.bpf.h.
std::uint32_t priority_of(const Sender& sender);

struct Outcome {
  bool dropped = false;
  std::uint32_t mark = 0;
  bool operator==(const Outcome&) const = default;
};

class LoadedGate {
 public:
  /// Aborts the test program where the kernel refuses the object.
  explicit LoadedGate(const GateOptions& options = {});
  /// One loaded gate for each set of options, as new: loading takes far longer than a frame.
  static LoadedGate& with(const GateOptions& options = {});
  LoadedGate(const LoadedGate&) = delete;
  LoadedGate& operator=(const LoadedGate&) = delete;

  Outcome run(gates::Direction direction, const Bytes& bytes, const Sender& sender = {}) const;
  /// What the program gives: TC_ACT_*.
  int action(gates::Direction direction, const Bytes& bytes, const Sender& sender = {}) const;
  /// skb->priority of what is let out.
  std::uint32_t band(const Bytes& bytes, const Sender& sender) const;
  /// Average ns of a run.
  std::uint32_t time(gates::Direction direction, const Bytes& bytes, const Sender& sender,
                     int repeat) const;

  [[nodiscard]] gate_table& table() const;
  [[nodiscard]] gate_control& control() const;
  [[nodiscard]] int control_fd() const;
  [[nodiscard]] std::span<gate_cpu> cpus() const { return cpus_.span(); }
  [[nodiscard]] gates::SlotTable& slots() { return *slots_; }

  /// No slots, no counts, open and enforcing.
  void reset();

  /// Adds slots one after the other; the last is the first of its chain.
  void admit(const std::vector<gates::SlotSpec>& specs);

 private:
  /// Runs a frame; `context` is what the program was given and left behind.
  bpf_test_run_opts execute(gates::Direction direction, const Bytes& bytes, __sk_buff& context,
                            const Sender& sender, int repeat) const;

  std::uint32_t profile_;
  std::unique_ptr<gate_test_bpf, void (*)(gate_test_bpf*)> object_;
  gates::Mapped<gate_cpu> cpus_;
  std::unique_ptr<gates::SlotTable> slots_;
};

}  // namespace mlcca::test
