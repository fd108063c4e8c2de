// SPDX-License-Identifier: BSD-2-Clause
// Speed and carrier of an Ethernet interface of this machine, from rtnetlink and ethtool netlink.
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

/// RTM_NEWLINK
struct Interface {
  std::string mac;
  std::uint32_t index = 0;  ///< ifindex
  bool running = false;     ///< up and with a carrier (IFF_RUNNING)
};
/// Nothing for another message, or an interface without an Ethernet address.
[[nodiscard]] std::optional<Interface> read_interface(genl::Octets message);

/// ETHTOOL_MSG_LINKMODES_GET_REPLY
struct LinkModes {
  std::optional<Value> speed;  ///< bit/s; nothing: the driver does not know
  bool half_duplex = false;
};
/// Nothing for another message.
[[nodiscard]] std::optional<LinkModes> read_link_modes(genl::Octets message);

/// Links in both directions between the interface and every other node of `nodes`; none without a
/// carrier. All in one direction share the wire's time, in both directions if it is half duplex:
/// that is said by channel numbers that no radio has, from 2^31 up. `now`: CLOCK_MONOTONIC ns.
[[nodiscard]] core::mesh::Snapshot view(const Interface& interface, const LinkModes& modes,
                                        const std::vector<std::string>& nodes, std::uint64_t now);

}  // namespace wire

/// Polls each second, and whenever the kernel reports that an interface changed, the interface
/// `source.interface`, which may come later. A wire does not say who is at its other end: it is
/// taken to lead to every other node of `mesh`.
[[nodiscard]] Result<std::unique_ptr<LinkSource>> open_wire(const core::mesh::Source& source,
                                                            const core::mesh::Mesh& mesh,
                                                            sd_event* loop,
                                                            LinkSource::Report report);

}  // namespace mlcca::net
