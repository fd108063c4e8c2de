// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/readback/replica.hpp"

#include <fmt/format.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <poll.h>
#include <sched.h>
#include <sys/fsuid.h>
#include <sys/mount.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "core/handle.hpp"
#include "daemon/enforce/control.hpp"
#include "daemon/enforce/failure.hpp"
#include "daemon/enforce/gate.hpp"
#include "daemon/enforce/gate_pins.hpp"
#include "daemon/enforce/mapped.hpp"
#include "daemon/enforce/pins.hpp"
#include "daemon/enforce/programs.hpp"
#include "daemon/net/can_routes.hpp"
#include "daemon/net/pair.hpp"
#include "daemon/readback/probes.hpp"

namespace mlcca::readback {
namespace {

using enforce::Direction;
using enforce::failure;

/// Far ends have indices that no gateway reaches.
constexpr int kFarIndex = 1'000'000'000;
constexpr std::chrono::seconds kPatience{1};

/// A frame has come where it should go, has been counted as dropped, or neither.
enum class Fate : std::uint8_t { passed, dropped, lost };

/// Bound to an interface, made as a program of `uid` would. Its own frames do not come back to it.
Result<Fd> can_socket(int ifindex, std::uint32_t uid = 0) {
  setfsuid(uid);
  Fd fd(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW));
  setfsuid(0);
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = ifindex;
  const int on = 1;
  const int off = 0;
  if (::setsockopt(fd.get(), SOL_CAN_RAW, CAN_RAW_LOOPBACK, &off, sizeof off) != 0 ||
      ::setsockopt(fd.get(), SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on) != 0 ||
      ::bind(fd.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) != 0)
    return failure("a CAN socket", errno);
  return fd;
}

void drain(const Fd& fd) {
  canfd_frame frame{};
  while (::read(fd.get(), &frame, sizeof frame) > 0) {
  }
}

bool receives(const Fd& fd, const Probe& probe) {
  canfd_frame frame{};
  const auto size = ::read(fd.get(), &frame, sizeof frame);
  return size == static_cast<ssize_t>(probe.fd ? CANFD_MTU : CAN_MTU) && frame.can_id == probe.id &&
         frame.len == probe.len;
}

/// An error at the socket is a drop by the gate: its counter tells.
void send(const Fd& fd, const Probe& probe) {
  canfd_frame frame{};
  frame.can_id = probe.id;
  frame.len = static_cast<std::uint8_t>(probe.len);
  static_cast<void>(::write(fd.get(), &frame, probe.fd ? CANFD_MTU : CAN_MTU));
}

/// What a gate has pinned.
struct Pinned {
  Fd table;
  std::array<Fd, GATE_DIRECTIONS> programs;

  /// Of the instructions of its programs.
  [[nodiscard]] std::array<std::string, GATE_DIRECTIONS> tags() const {
    return {enforce::program_info(programs[0].get()).tag,
            enforce::program_info(programs[1].get()).tag};
  }
};

Pinned pinned_in(const std::string& directory) {
  return {enforce::open_pin(enforce::table_pin(directory)),
          {enforce::open_pin(enforce::program_pin(directory, Direction::ingress)),
           enforce::open_pin(enforce::program_pin(directory, Direction::egress))}};
}

struct Copy {
  const enforce::GateReading* original;
  enforce::Gate gate;
  Fd near;                    ///< a program on this machine
  Fd far;                     ///< the bus
  bool same_programs = true;  ///< as the original has

  [[nodiscard]] std::uint64_t drops() const {
    std::uint64_t sum = 0;
    for (const auto direction : enforce::kBothDirections) {
      const auto reasons = gate.reasons(direction);
      for (std::size_t r = 0; r < reasons.size(); ++r)
        if (enforce::is_drop(static_cast<gate_reason>(r))) sum += reasons.at(r);
    }
    return sum;
  }
};

/// Where a frame enters, where it must come out, and who may have dropped it on the way.
Fate fate_of(const Probe& probe, const Fd& from, const Fd& to, std::span<const Copy* const> gates) {
  const auto drops = [&] {
    std::uint64_t sum = 0;
    for (const Copy* copy : gates) sum += copy->drops();
    return sum;
  };
  drain(to);
  const std::uint64_t before = drops();
  const auto end = std::chrono::steady_clock::now() + kPatience;
  send(from, probe);
  do {
    pollfd wait{.fd = to.get(), .events = POLLIN, .revents = 0};
    const bool dropped = drops() != before;
    if (::poll(&wait, 1, dropped ? 0 : 1) == 1)
      if (receives(to, probe)) return Fate::passed;
    if (dropped) return Fate::dropped;
  } while (std::chrono::steady_clock::now() < end);
  return Fate::lost;
}

class Replica {
 public:
  static Result<std::unique_ptr<Replica>> make(const enforce::Reading& reading,
                                               const std::string& root);
  std::vector<Trial> run();

 private:
  Replica(const enforce::Reading& reading, enforce::Control control)
      : reading_(&reading), control_(std::move(control)) {}
  Result<void> copy(const enforce::GateReading& gate, const Pinned& in_force);
  Result<void> copy_control(const Fd& original);
  [[nodiscard]] Result<Fate> try_frame(const Probe& probe, const Copy& copy) const;
  void try_all(const Copy& copy, bool closed, Trial& trial);
  void try_one(const Probe& probe, const Copy& copy, bool closed, Trial& trial);
  void forward(std::uint32_t from, std::uint32_t to, bool wanted, Trial& trial);

  const enforce::Reading* reading_;
  enforce::Control control_;
  net::KernelCanRules rules_;
  std::vector<std::unique_ptr<Copy>> copies_;
};

/// Pins of the copies hide those of the originals from this process.
Result<void> enter_namespaces(const std::string& root) {
  if (::unshare(CLONE_NEWNET | CLONE_NEWNS) != 0) return failure("a namespace for probes", errno);
  if (::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0)
    return failure("private mounts", errno);
  if (::mount("bpf", root.c_str(), "bpf", 0, nullptr) != 0)
    return failure("a bpffs over " + root, errno);
  return {};
}

Result<std::unique_ptr<Replica>> Replica::make(const enforce::Reading& reading,
                                               const std::string& root) {
  const std::string pins = fmt::format("{}/v{}", root, GATE_LAYOUT_VERSION);
  const Fd original = enforce::open_pin(pins + "/control");
  std::map<std::uint32_t, Pinned> in_force;
  for (const auto& gate : reading.gates)
    in_force[gate.ifindex] = pinned_in(enforce::gate_directory(pins, gate.ifindex));
  if (auto done = enter_namespaces(root); !done) return std::unexpected(done.error());
  auto control = enforce::Control::create(root);
  if (!control) return std::unexpected(control.error());
  std::unique_ptr<Replica> replica(new Replica(reading, std::move(*control)));
  if (auto done = replica->copy_control(original); !done) return std::unexpected(done.error());
  for (const auto& gate : reading.gates)
    if (!gate.slots.empty())
      if (auto done = replica->copy(gate, in_force[gate.ifindex]); !done)
        return std::unexpected(done.error());
  return replica;
}

/// The copies judge even in audit mode.
Result<void> Replica::copy_control(const Fd& original) {
  const enforce::Mapped<gate_control> from(original.get(), 1);
  const enforce::Mapped<gate_control> to(control_.map_fd(), 1);
  if (!from || !to) return failure("map the control word", errno);
  to[0] = from[0];
  to[0].mode = GATE_ENFORCE;
  to[0].armed = 0;
  return {};
}

/// Byte by byte; but nothing is policed, and nobody watches.
Result<void> Replica::copy(const enforce::GateReading& gate, const Pinned& in_force) {
  const int far = kFarIndex + static_cast<int>(copies_.size());
  if (auto made = net::make_pair("vxcan", {gate.interface, static_cast<int>(gate.ifindex)},
                                 {"far" + std::to_string(copies_.size()), far});
      !made)
    return made;
  enforce::GateConfig config;
  config.ifindex = gate.ifindex;
  config.name = gate.interface;
  config.profile = enforce::core_profile_of(gate.profile);
  auto attached = enforce::Gate::attach(config, control_);
  auto near = can_socket(static_cast<int>(gate.ifindex));
  auto far_end = can_socket(far);
  if (!attached) return std::unexpected(attached.error());
  if (!near || !far_end) return std::unexpected((near ? far_end : near).error());
  const Pinned own = pinned_in(enforce::gate_directory(control_.directory(), gate.ifindex));
  const enforce::Mapped<gate_table> from(in_force.table.get(), 1);
  const enforce::Mapped<gate_table> to(own.table.get(), 1);
  if (!from || !to) return failure("map the table of " + gate.interface, errno);
  std::memcpy(&to[0], &from[0], sizeof(gate_table));
  for (gate_slot& slot : to[0].slots) slot.per_frame = slot.per_byte = 0;
  for (gate_watch& watch : to[0].watches) watch = {};
  copies_.push_back(
      std::make_unique<Copy>(Copy{&gate, std::move(*attached), std::move(*near),
                                  std::move(*far_end), own.tags() == in_force.tags()}));
  return {};
}

std::vector<Trial> Replica::run() {
  std::vector<Trial> trials;
  for (const auto& copy : copies_) {
    Trial& trial = trials.emplace_back();
    trial.ifindex = copy->original->ifindex;
    if (!copy->same_programs)
      trial.problems.emplace_back(
          "its programs are those of another version than this one: restart mlccad");
  }
  const bool open = control_.is_open() && !control_.lapsed();
  for (std::size_t i = 0; open && i < copies_.size(); ++i) try_all(*copies_[i], false, trials[i]);
  control_.close_all();
  for (std::size_t i = 0; i < copies_.size(); ++i) try_all(*copies_[i], true, trials[i]);
  return trials;
}

/// Sorted by the way and then by the source: a rule of the forwarder stays for all its frames.
void Replica::try_all(const Copy& copy, bool closed, Trial& trial) {
  const Probes probes = probes_for(*copy.original);
  std::map<std::uint32_t, std::vector<Probe>> through;
  for (const Probe& probe : probes.frames)
    if (probe.way == Probe::Way::through)
      through[probe.source].push_back(probe);
    else
      try_one(probe, copy, closed, trial);
  for (const auto& [source, frames] : through) {
    if (std::ranges::none_of(
            copies_, [&, from = source](const auto& c) { return c->original->ifindex == from; })) {
      if (!closed)
        trial.untried.push_back(
            fmt::format("what comes by interface {}: it has no CAN gate with slots", source));
      continue;
    }
    const std::size_t before = trial.untried.size();
    forward(source, copy.original->ifindex, true, trial);
    if (trial.untried.size() != before) continue;
    for (const Probe& probe : frames) try_one(probe, copy, closed, trial);
    forward(source, copy.original->ifindex, false, trial);
  }
  if (probes.untried != 0 && !closed)
    trial.untried.push_back(
        fmt::format("{} slots for CAN XL or for what the kernel sends", probes.untried));
}

void Replica::forward(std::uint32_t from, std::uint32_t to, bool wanted, Trial& trial) {
  for (const bool fd : {false, true}) {
    net::CanRule frames;
    frames.from = static_cast<int>(from);
    frames.to = static_cast<int>(to);
    frames.fd = fd;
    const auto rule = net::ours(frames, net::kFirstUid + (fd ? 1 : 0));
    const auto done = wanted ? rules_.add(rule) : rules_.remove(rule);
    if (done) continue;
    trial.untried.push_back(fmt::format("what comes by interface {}: {}", from, done.error().text));
    return;
  }
}

Result<Fate> Replica::try_frame(const Probe& probe, const Copy& copy) const {
  const Copy* gates[] = {&copy, &copy};  // NOLINT(*-avoid-c-arrays)
  if (probe.way == Probe::Way::in) return fate_of(probe, copy.far, copy.near, {gates, 1});
  if (probe.way == Probe::Way::out) {
    const auto program = can_socket(static_cast<int>(copy.original->ifindex), probe.uid);
    if (!program) return std::unexpected(program.error());
    return fate_of(probe, *program, copy.far, {gates, 1});
  }
  const auto source = std::ranges::find_if(
      copies_, [&](const auto& c) { return c->original->ifindex == probe.source; });
  gates[1] = source->get();
  return fate_of(probe, gates[1]->far, copy.far, gates);
}

void Replica::try_one(const Probe& probe, const Copy& copy, bool closed, Trial& trial) {
  const bool pass = !closed && is_admitted(probe, *copy.original, reading_->gates);
  const auto fate = try_frame(probe, copy);
  if (!fate) {
    trial.untried.push_back(to_text(probe) + ": " + fate.error().text);
  } else if (*fate == Fate::lost) {
    trial.problems.push_back(to_text(probe) + ": neither came out nor was counted as dropped");
  } else if ((*fate == Fate::passed) != pass) {
    trial.problems.push_back(fmt::format("{} {}{}", to_text(probe),
                                         pass ? "was dropped although it is admitted" : "passed",
                                         pass     ? ""
                                         : closed ? " a closed gate"
                                                  : " although it is not admitted"));
  } else {
    ++(pass ? trial.passed : trial.dropped);
  }
}

}  // namespace

Result<std::vector<Trial>> try_gates(const enforce::Reading& reading, const std::string& root) {
  auto replica = Replica::make(reading, root);
  if (!replica) return std::unexpected(replica.error());
  return (*replica)->run();
}

}  // namespace mlcca::readback
