// SPDX-License-Identifier: BSD-2-Clause
#include "tools/readback/replica.hpp"

#include <fmt/format.h>
#include <sched.h>
#include <sys/mount.h>

#include <cerrno>
#include <map>
#include <string>
#include <utility>

#include "daemon/gates/control.hpp"
#include "daemon/gates/failure.hpp"
#include "daemon/gates/mapped.hpp"
#include "tools/readback/can_copies.hpp"
#include "tools/readback/ether_copy.hpp"

namespace mlcca::readback {
namespace {

using gates::failure;

/// Enters new namespaces. The bpffs that is mounted there hides the original pins from this
/// process.
Result<void> enter_namespaces(const std::string& root) {
  if (::unshare(CLONE_NEWNET | CLONE_NEWNS) != 0) return failure("a namespace for probes", errno);
  if (::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0)
    return failure("private mounts", errno);
  if (::mount("bpf", root.c_str(), "bpf", 0, nullptr) != 0)
    return failure("a bpffs over " + root, errno);
  return {};
}

/// Copies the control word so that the copies enforce even in audit mode, without limit and
/// heart-beat. Verdicts that the daemon has put in force since the reading do not apply to them.
Result<void> copy_control(const Fd& original, std::uint32_t generation,
                          const gates::Control& control) {
  const gates::Mapped<gate_control> from(original.get(), 1);
  const gates::Mapped<gate_control> to(control.map_fd(), 1);
  if (!from || !to) return failure("map the control word", errno);
  to[0] = from[0];
  to[0].generation = generation;
  to[0].mode = GATE_ENFORCE;
  to[0].armed = 0;
  to[0].deadline = gates::kForEver;
  return {};
}

class Replica {
 public:
  Replica(const gates::Reading& reading, gates::Control control)
      : control_(std::move(control)), can_(reading, control_) {}
  Replica(const Replica&) = delete;
  Replica& operator=(const Replica&) = delete;
  Replica(Replica&&) = delete;
  Replica& operator=(Replica&&) = delete;
  ~Replica() = default;

  void add(const gates::GateReading& gate, const Original& original) {
    Trial& trial = trials_[gate.ifindex];
    trial.ifindex = gate.ifindex;
    Result<void> added;
    if (!gate.ethernet) {
      added = can_.add(gate, original);
    } else if (auto copy = EtherCopy::make(gate, original, control_)) {
      ether_.emplace(gate.ifindex, std::move(*copy));
    } else {
      added = std::unexpected(copy.error());
    }
    if (added) return;
    auto& list = added.error().text == kOtherVersion ? trial.problems : trial.untried;
    list.push_back(added.error().text);
  }

  std::vector<Trial> run() {
    if (control_.is_open() && !control_.lapsed()) run(false);
    control_.close_all();
    run(true);
    std::vector<Trial> trials;
    trials.reserve(trials_.size());
    for (auto& [ifindex, trial] : trials_) trials.push_back(std::move(trial));
    return trials;
  }

 private:
  void run(bool closed) {
    for (auto& [ifindex, trial] : trials_) {
      can_.run(ifindex, closed, trial);
      if (const auto copy = ether_.find(ifindex); copy != ether_.end())
        copy->second.run(closed, trial);
    }
  }

  gates::Control control_;
  CanCopies can_;
  std::map<std::uint32_t, EtherCopy> ether_;
  std::map<std::uint32_t, Trial> trials_;
};

}  // namespace

Result<std::vector<Trial>> try_gates(const gates::Reading& reading, const std::string& root) {
  const std::string pins = fmt::format("{}/v{}", root, GATE_LAYOUT_VERSION);
  const Fd word = gates::open_pin(pins + "/control");
  std::map<std::uint32_t, Original> originals;
  for (const auto& gate : reading.gates)
    originals.emplace(gate.ifindex, Original(gates::gate_directory(pins, gate.ifindex)));
  if (auto done = enter_namespaces(root); !done) return std::unexpected(done.error());
  auto control = gates::Control::create(root);
  if (!control) return std::unexpected(control.error());
  if (auto done = copy_control(word, reading.generation, *control); !done)
    return std::unexpected(done.error());
  Replica replica(reading, std::move(*control));
  for (const auto& gate : reading.gates)
    if (!gate.slots.empty()) replica.add(gate, originals.at(gate.ifindex));
  return replica.run();
}

}  // namespace mlcca::readback
