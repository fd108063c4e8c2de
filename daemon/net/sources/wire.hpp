// SPDX-License-Identifier: BSD-2-Clause
// The speed and carrier of an Ethernet interface of this machine, read from rtnetlink and ethtool
// netlink.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/net/sources/genl.hpp"
#include "daemon/net/sources/source.hpp"

namespace mlcca::net {
namespace wire {

/// RTM_NEWLINK: the interface.
struct Interface {
  std::string mac;
  std::uint32_t index = 0;  ///< ifindex
  bool running = false;     ///< up and with a carrier (IFF_RUNNING)
};
/// nullopt for another message, or an interface without an Ethernet address.
[[nodiscard]] std::optional<Interface> read_interface(genl::Octets message);

/// ETHTOOL_MSG_LINKMODES_GET_REPLY: the modes of its link.
struct LinkModes {
  std::optional<Value> speed;  ///< bit/s; nullopt: the driver does not know
  bool half_duplex = false;
};
/// nullopt for another message.
[[nodiscard]] std::optional<LinkModes> read_link_modes(genl::Octets message);

/// The links in both directions between the interface and every other node of `nodes`; none without
/// a carrier. All links of one direction share the time of the wire; with half duplex, those of
/// both directions. Channel numbers from 2^31 up, which no radio has, express that. `now`:
/// CLOCK_MONOTONIC ns.
[[nodiscard]] core::mesh::Snapshot view(const Interface& interface, const LinkModes& modes,
                                        const std::vector<std::string>& nodes, std::uint64_t now);

}  // namespace wire

/// Polls the interface `source.interface` each second, and whenever the kernel reports that an
/// interface has changed. The interface may appear later. A wire does not state what is at its
/// other end, so it counts as a link to every other node of `mesh`.
[[nodiscard]] Result<std::unique_ptr<LinkSource>> open_wire(const core::mesh::Source& source,
                                                            const core::mesh::Mesh& mesh,
                                                            sd_event* loop,
                                                            LinkSource::Report report);

}  // namespace mlcca::net
