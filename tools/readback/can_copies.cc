// SPDX-License-Identifier: BSD-2-Clause
#include "tools/readback/can_copies.hpp"

#include <fmt/format.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <sys/fsuid.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>
#include <utility>

#include "base/many.hpp"
#include "daemon/gates/failure.hpp"
#include "daemon/gates/mapped.hpp"
#include "daemon/gates/programs.hpp"
#include "daemon/net/pair.hpp"

namespace mlcca::readback {
namespace {

using gates::failure;

/// A CAN socket bound to an interface, created with the file-system user `uid`. It does not receive
/// its own frames.
Result<Fd> can_socket(int ifindex, std::uint32_t uid = 0) {
  setfsuid(uid);
  Fd fd(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW));
  setfsuid(0);
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = ifindex;
  const int on = 1;
  const int off = 0;
  if (!fd || ::setsockopt(fd.get(), SOL_CAN_RAW, CAN_RAW_LOOPBACK, &off, sizeof off) != 0 ||
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

/// Sends a frame. False if write() fails, as it does when the gate drops the frame.
bool send(const Fd& fd, const Probe& probe) {
  canfd_frame frame{};
  frame.can_id = probe.id;
  frame.len = static_cast<std::uint8_t>(probe.len);
  return ::write(fd.get(), &frame, probe.fd ? CANFD_MTU : CAN_MTU) > 0;
}

}  // namespace

/// Makes the copy with the same bytes that were read, but without policing and supervision.
Result<void> CanCopies::add(const gates::GateReading& gate, const Original& original) {
  const int far = kFarIndex + static_cast<int>(gate.ifindex);
  if (auto made = net::make_pair("vxcan", {gate.interface, static_cast<int>(gate.ifindex)},
                                 {fmt::format("far{}", gate.ifindex), far});
      !made)
    return made;
  gates::GateConfig config;
  config.ifindex = gate.ifindex;
  config.name = gate.interface;
  config.profile = gates::core_profile_of(gate.profile);
  auto attached = gates::Gate::attach(config, *control_);
  auto near = can_socket(static_cast<int>(gate.ifindex));
  auto far_end = can_socket(far);
  if (!attached) return std::unexpected(attached.error());
  if (!near || !far_end) return std::unexpected((near ? far_end : near).error());
  const std::string pins = gates::gate_directory(control_->directory(), gate.ifindex);
  const Fd table = gates::open_pin(gates::table_pin(pins));
  const gates::Mapped<gate_table> to(table.get(), 1);
  if (!to) return failure("map the table of " + gate.interface, errno);
  std::memcpy(&to[0], gate.can_image.get(), sizeof(gate_table));
  for (gate_slot& slot : to[0].slots) slot.per_frame = slot.per_byte = 0;
  for (gate_watch& watch : to[0].watches) watch = {};
  copies_.push_back(std::make_unique<Copy>(
      Copy{&gate, std::move(*attached), std::move(*near), std::move(*far_end)}));
  if (Original(pins).tags != original.tags) return fail(kOtherVersion);
  return {};
}

const CanCopies::Copy* CanCopies::find(std::uint32_t ifindex) const {
  const auto copy =
      std::ranges::find_if(copies_, [&](const auto& c) { return c->original->ifindex == ifindex; });
  return copy == copies_.end() ? nullptr : copy->get();
}

/// Tries frames that arrive at interface `source` and are forwarded.
void CanCopies::run_through(std::uint32_t source, const std::vector<Probe>& frames,
                            const Copy& copy, bool closed, Trial& trial) {
  const std::uint32_t ifindex = copy.original->ifindex;
  const auto forwarded = find(source) != nullptr
                             ? forward(source, ifindex, true)
                             : Result<void>(fail("it has no CAN gate with slots"));
  if (!forwarded) {
    if (!closed)
      trial.untried.push_back(
          fmt::format("what comes by interface {}: {}", source, forwarded.error().text));
    return;
  }
  std::size_t renamed = 0;
  for (const Probe& probe : frames) {
    try_one(probe, copy, closed, trial);
    if (enters_otherwise(probe, *copy.original, reading_->gates)) ++renamed;
  }
  static_cast<void>(forward(source, ifindex, false));
  if (renamed != 0 && !closed)
    trial.untried.push_back(fmt::format("{} by interface {} that {} there with another identifier",
                                        many(renamed, "frame"), source,
                                        renamed == 1 ? "enters" : "enter"));
}

/// Forwarded frames are sorted by source, so that one forwarding rule serves all frames of a
/// source.
void CanCopies::run(std::uint32_t ifindex, bool closed, Trial& trial) {
  const Copy* const copy = find(ifindex);
  if (copy == nullptr) return;
  const Probes probes = probes_for(*copy->original);
  std::map<std::uint32_t, std::vector<Probe>> through;
  for (const Probe& probe : probes.frames)
    if (probe.way == Probe::Way::through)
      through[probe.source].push_back(probe);
    else
      try_one(probe, *copy, closed, trial);
  for (const auto& [source, frames] : through) run_through(source, frames, *copy, closed, trial);
  if (probes.untried != 0 && !closed)
    trial.untried.push_back(many(probes.untried, "slot") +
                            " for CAN XL or for what the kernel sends");
}

Result<void> CanCopies::forward(std::uint32_t from, std::uint32_t to, bool wanted) {
  for (const bool fd : {false, true}) {
    net::CanRule frames;
    frames.from = static_cast<int>(from);
    frames.to = static_cast<int>(to);
    frames.fd = fd;
    const auto rule = net::ours(frames, net::kFirstUid + (fd ? 1 : 0));
    if (auto done = wanted ? rules_.add(rule) : rules_.remove(rule); !done) return done;
  }
  return {};
}

/// Determines where the frame enters, where it must leave, and which gates may drop it on the way.
Result<Fate> CanCopies::fate(const Probe& probe, const Copy& copy) const {
  const auto between = [&](const Fd& from, const Fd& to, const Copy& first) {
    const auto drops = [&] {
      return drops_of(copy.gate) + (&first == &copy ? 0 : drops_of(first.gate));
    };
    drain(to);
    return fate_of(
        to, drops, [&] { return send(from, probe); }, [&] { return receives(to, probe); });
  };
  if (probe.way == Probe::Way::in) return between(copy.far, copy.near, copy);
  if (probe.way == Probe::Way::out) {
    const auto program = can_socket(static_cast<int>(copy.original->ifindex), probe.uid);
    if (!program) return std::unexpected(program.error());
    return between(*program, copy.far, copy);
  }
  const Copy& source = *find(probe.source);
  return between(source.far, copy.far, source);
}

void CanCopies::try_one(const Probe& probe, const Copy& copy, bool closed, Trial& trial) const {
  const auto became = fate(probe, copy);
  if (became)
    trial.note(to_text(probe), *became, is_admitted(probe, *copy.original, reading_->gates),
               closed);
  else
    trial.untried.push_back(to_text(probe) + ": " + became.error().text);
}

}  // namespace mlcca::readback
