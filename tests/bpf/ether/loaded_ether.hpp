// SPDX-License-Identifier: BSD-2-Clause
// The real Ethernet gate, loaded but not attached, and packets run through it by BPF_PROG_TEST_RUN.
#pragma once
#include <linux/bpf.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "daemon/gates/closed_programs.hpp"
#include "daemon/gates/counters.hpp"
#include "daemon/gates/ether_table.hpp"
#include "daemon/gates/mapped.hpp"
#include "tests/bpf/ether/packets.hpp"

struct bpf_program;
struct ether_test_bpf;

namespace mlcca::test {

inline constexpr std::uint32_t kIfindex = 7;  ///< of the gate under test
inline constexpr std::uint32_t kOther = 9;    ///< another interface with a gate
inline constexpr std::uint32_t kToken = 0xa5c30f1e;

struct EtherOptions {
  bool direct_access = true;
  bool atomic_counts = false;
  std::size_t slots = 0;
  bool wpan = false;

  auto operator<=>(const EtherOptions&) const = default;
};

struct Sender {
  bool local = false;  ///< a program of user 0
  std::uint32_t mark = 0;
  std::uint32_t ingress_ifindex = 0;
  std::uint32_t segment = 0;  ///< bytes of each datagram in a buffer with several
};

struct Outcome {
  bool dropped = false;
  std::uint32_t mark = 0;
  bool operator==(const Outcome&) const = default;
};

class LoadedEther {
 public:
  /// Aborts the test program where the kernel refuses the object.
  explicit LoadedEther(const EtherOptions& options = {});
  /// One loaded gate for each set of options, as new.
  static LoadedEther& with(const EtherOptions& options = {});
  LoadedEther(const LoadedEther&) = delete;
  LoadedEther& operator=(const LoadedEther&) = delete;

  Outcome run(gates::Direction direction, const Bytes& bytes, const Sender& sender = {}) const;
  /// Whether the program in the driver drops it.
  [[nodiscard]] bool dropped_early(const Bytes& bytes) const;
  [[nodiscard]] int program_fd(gates::Direction direction) const;
  [[nodiscard]] int early_fd() const;

  /// Runs it so often.
  void repeat(gates::Direction direction, const Bytes& bytes, int times) const;
  [[nodiscard]] gate_control& control() const;
  [[nodiscard]] int control_fd() const;
  [[nodiscard]] gates::EtherTable& table() { return *table_; }
  [[nodiscard]] const gates::EtherMemory& memory() const { return memory_; }
  [[nodiscard]] const gates::EtherSizes& sizes() const { return sizes_; }
  [[nodiscard]] std::span<ether_cpu> cpus() const { return cpus_.span(); }
  [[nodiscard]] gates::SlotCounters counted(const gates::SlotSpec& spec) const;
  /// Of the direction's own slot.
  [[nodiscard]] gates::SlotCounters counted(gates::Direction direction) const;
  [[nodiscard]] gates::ReasonCounters reasons(gates::Direction direction) const;
  [[nodiscard]] gates::ReasonCounters would_drop(gates::Direction direction) const;
  /// Kernel memory of all maps, as /proc has it.
  [[nodiscard]] std::size_t map_bytes() const;

  /// No slots, no counts, no fragments, open and enforcing.
  void reset();
  void admit(const std::vector<gates::SlotSpec>& specs);

 private:
  gates::EtherSizes sizes_;
  std::unique_ptr<ether_test_bpf, void (*)(ether_test_bpf*)> object_;
  gates::Mapped<std::uint64_t> buckets_;
  gates::Mapped<ether_prefilter_part> prefilters_;
  gates::Mapped<ether_slot> slots_;
  gates::Mapped<ether_contract> contracts_;
  gates::Mapped<gate_count> counts_;
  gates::Mapped<gate_audit> audits_;
  gates::Mapped<ether_cpu> cpus_;
  gates::Mapped<gate_watch> watches_;
  gates::EtherMemory memory_;
  std::unique_ptr<gates::EtherTable> table_;
};

/// What an interface gets before there is a daemon.
bool drops(const gates::ClosedPrograms& closed, gates::Direction direction, const Bytes& bytes);

}  // namespace mlcca::test
