// SPDX-License-Identifier: BSD-2-Clause
#include "tools/readback/ether_copy.hpp"

#include <fmt/format.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <netinet/in.h>
#include <sys/fsuid.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "daemon/gates/failure.hpp"
#include "daemon/gates/mapped.hpp"
#include "daemon/net/pair.hpp"

namespace mlcca::readback {
namespace {

using gates::failure;

/// A packet socket for one EtherType, behind the gate, created with the file-system user `uid`.
Result<Fd> packet_socket(int ifindex, std::uint16_t ethertype, std::uint32_t uid = 0) {
  setfsuid(uid);
  Fd fd(::socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  setfsuid(0);
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(ethertype);
  address.sll_ifindex = ifindex;
  if (!fd || ::bind(fd.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) != 0)
    return failure("a packet socket", errno);
  return fd;
}

bool receives(const Fd& fd, const std::vector<std::uint8_t>& frame) {
  std::vector<std::uint8_t> got(frame.size() + 1);
  const auto size = ::read(fd.get(), got.data(), got.size());
  return size == std::ssize(frame) && std::equal(frame.begin(), frame.end(), got.begin());
}

template <class T>
bool fill(const Fd& to, const std::vector<T>& from) {
  const gates::Mapped<T> memory(to.get(), from.size());
  if (!memory) return false;
  std::ranges::copy(from, memory.span().begin());
  return true;
}

/// Copies the tables byte by byte, but without policing and supervision.
Result<void> copy_table(const gates::EtherImage& from, const gates::EtherPinned& to) {
  if (from.sizes != to.sizes) return fail("its copy has another size");
  if (!fill(to.maps.table, from.table) || !fill(to.maps.buckets, from.buckets) ||
      !fill(to.maps.prefilter, from.prefilters) || !fill(to.maps.slots, from.slots) ||
      !fill(to.maps.contracts, from.contracts))
    return failure("map the table", errno);
  const gates::Mapped<ether_contract> contracts(to.maps.contracts.get(), to.sizes.contracts);
  if (!contracts) return failure("map the contracts", errno);
  for (ether_contract& c : contracts.span()) c.per_frame = c.per_byte = 0;
  return {};
}

}  // namespace

EtherCopy::EtherCopy(const gates::GateReading& gate, gates::EtherGate copy)
    : gate_(std::move(copy)), near_index_(static_cast<int>(gate.ifindex)), probes_(gate) {}

Result<EtherCopy::Ends> EtherCopy::open_ends(int near, int far, std::uint16_t ethertype) {
  auto at_gate = packet_socket(near, ethertype);
  auto on_wire = packet_socket(far, ethertype);
  if (!at_gate || !on_wire) return std::unexpected((at_gate ? on_wire : at_gate).error());
  return Ends{std::move(*at_gate), std::move(*on_wire)};
}

Result<EtherCopy> EtherCopy::make(const gates::GateReading& gate, const Original& original,
                                  const gates::Control& control) {
  const int near_index = static_cast<int>(gate.ifindex);
  const int far_index = kFarIndex + near_index;
  if (auto made = net::make_pair("veth", {gate.interface, near_index},
                                 {fmt::format("far{}", gate.ifindex), far_index});
      !made)
    return std::unexpected(made.error());
  gates::EtherConfig config;
  config.ifindex = gate.ifindex;
  config.name = gate.interface;
  config.slots = gate.ether_image->sizes.slots - ETHER_FIRST_SLOT;
  config.framing = gate.wpan ? gates::Framing::wpan : gates::Framing::ethernet;
  auto copy = gates::EtherGate::attach(config, control);
  if (!copy) return std::unexpected(copy.error());
  const std::string pins = gates::gate_directory(control.directory(), gate.ifindex);
  const auto own = gates::pinned_ether_maps(pins);
  if (!own) return fail("its copy has no maps");
  if (auto copied = copy_table(*gate.ether_image, *own); !copied)
    return std::unexpected(copied.error());
  if (Original(pins).tags != original.tags) return fail(kOtherVersion);
  return EtherCopy(gate, std::move(*copy));
}

void EtherCopy::run(bool closed, Trial& trial) {
  for (const EtherProbe& probe : probes_.probes()) {
    const auto became = fate(probe);
    if (became)
      trial.note(to_text(probe), *became, probes_.is_admitted(probe), closed);
    else
      trial.untried.push_back(to_text(probe) + ": " + became.error().text);
  }
  if (!closed)
    trial.untried.insert(trial.untried.end(), probes_.untried().begin(), probes_.untried().end());
}

/// A frame that leaves is sent by the socket of its user, one that arrives by the far end.
Result<Fate> EtherCopy::fate(const EtherProbe& probe) {
  const std::uint16_t ethertype = ethertype_of(probe);
  if (!ends_.contains(ethertype)) {
    auto opened = open_ends(near_index_, kFarIndex + near_index_, ethertype);
    if (!opened) return std::unexpected(opened.error());
    ends_.emplace(ethertype, std::move(*opened));
  }
  const Ends& ends = ends_.at(ethertype);
  Fd program;
  if (probe.out) {
    auto made = packet_socket(near_index_, ethertype, probe.uid);
    if (!made) return std::unexpected(made.error());
    program = std::move(*made);
  }
  const Fd& from = probe.out ? program : ends.far;
  const Fd& to = probe.out ? ends.far : ends.near;
  const auto frame = frame_of(probe);
  // It fails as well when the gate drops the frame.
  const auto send = [&] { return ::write(from.get(), frame.data(), frame.size()) > 0; };
  return fate_of(to, [&] { return drops_of(gate_); }, send, [&] { return receives(to, frame); });
}

}  // namespace mlcca::readback
