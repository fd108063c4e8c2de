// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/sources/wire.hpp"

#include <linux/ethtool.h>
#include <linux/ethtool_netlink.h>
#include <linux/if.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <netlink/attr.h>
#include <netlink/msg.h>
#include <netlink/netlink.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "daemon/net/sources/kernel_source.hpp"

namespace mlcca::net {
namespace wire {
namespace {

constexpr Value kMegabit = 1'000'000;  // bit/s
constexpr std::uint32_t kFirstChannel = 1U << 31;

}  // namespace

std::optional<Interface> read_interface(genl::Octets message) {
  const auto attributes = genl::read_route_message(message, RTM_NEWLINK, sizeof(ifinfomsg));
  if (!attributes) return {};
  auto mac = attributes->mac(IFLA_ADDRESS);
  if (!mac) return {};
  ifinfomsg fixed{};
  std::memcpy(&fixed, message.data() + NLMSG_HDRLEN, sizeof fixed);  // the size was checked
  return Interface{.mac = std::move(*mac),
                   .index = static_cast<std::uint32_t>(fixed.ifi_index),
                   .running = (fixed.ifi_flags & IFF_RUNNING) != 0};
}

std::optional<LinkModes> read_link_modes(genl::Octets message) {
  const auto read = genl::read_message(message);
  if (!read || read->command != ETHTOOL_MSG_LINKMODES_GET_REPLY) return {};
  LinkModes out;
  const auto speed = read->attributes.u32(ETHTOOL_A_LINKMODES_SPEED);
  if (speed && *speed != 0 && *speed != static_cast<std::uint32_t>(SPEED_UNKNOWN))
    out.speed = *speed * kMegabit;
  // An unknown duplex counts as half duplex, which carries less.
  out.half_duplex =
      read->attributes.u8(ETHTOOL_A_LINKMODES_DUPLEX) != std::optional<std::uint8_t>(DUPLEX_FULL);
  return out;
}

core::mesh::Snapshot view(const Interface& interface, const LinkModes& modes,
                          const std::vector<std::string>& nodes, std::uint64_t now) {
  core::mesh::Snapshot out;
  if (!interface.running) return out;
  const std::uint32_t channel = kFirstChannel + 2 * interface.index;
  for (const std::string& node : nodes) {
    if (node == interface.mac) continue;
    core::mesh::Sample there;
    there.from = interface.mac;
    there.to = node;
    there.rate = modes.speed.value_or(0);
    there.kind = core::mesh::RateKind::phy;
    there.channel = channel;
    there.taken = now;
    core::mesh::Sample back = there;
    std::swap(back.from, back.to);
    if (!modes.half_duplex) back.channel = channel + 1;
    out.links.push_back(std::move(there));
    out.links.push_back(std::move(back));
  }
  return out;
}

}  // namespace wire

namespace {

class WireSource : public KernelSource {
 public:
  WireSource(std::string interface, std::vector<std::string> nodes, sd_event* loop, Report report)
      : KernelSource(loop, std::move(report)),
        interface_(std::move(interface)),
        nodes_(std::move(nodes)) {}

 private:
  void poll() override {
    seen_.reset();
    modes_ = {};
    ask_link(
        interface_, [this](genl::Octets octets) { seen_ = wire::read_interface(octets); },
        [this] {
          if (seen_)
            find_ethtool();
          else
            report_problem(interface_ + " has no Ethernet address");
        });
  }

  void find_ethtool() {
    Conversation* const kernel = talk(NETLINK_GENERIC);
    if (kernel == nullptr) return;
    kernel->find_family(ETHTOOL_GENL_NAME, [this](Result<std::uint16_t> family) {
      if (!family) {
        report_problem(std::move(family.error().text));
        return;
      }
      ask_speed(*talk(NETLINK_GENERIC), *family);
    });
  }

  void ask_speed(Conversation& kernel, std::uint16_t family) {
    auto request = Conversation::generic_request(family, ETHTOOL_MSG_LINKMODES_GET, 0);
    if (request) {
      nlattr* const header = nla_nest_start(request.get(), ETHTOOL_A_LINKMODES_HEADER);
      nla_put_string(request.get(), ETHTOOL_A_HEADER_DEV_NAME, interface_.c_str());
      nla_nest_end(request.get(), header);
    }
    kernel.ask(
        std::move(request),
        [this](genl::Octets octets) {
          if (auto modes = wire::read_link_modes(octets)) modes_ = *modes;
        },
        [this](int error) {
          // A driver without link modes: the wire exists, and its speed is unknown.
          if (error != 0 && error != EOPNOTSUPP) {
            report_refusal("speed of " + interface_, error);
            return;
          }
          report(wire::view(*seen_, modes_, nodes_, now()));
        });
  }

  std::string interface_;
  std::vector<std::string> nodes_;
  std::optional<wire::Interface> seen_;
  wire::LinkModes modes_;
};

}  // namespace

Result<std::unique_ptr<LinkSource>> open_wire(const core::mesh::Source& source,
                                              const core::mesh::Mesh& mesh, sd_event* loop,
                                              LinkSource::Report report) {
  if (source.interface.empty()) return fail("a source wire needs the name of an interface");
  std::vector<std::string> nodes;
  nodes.reserve(mesh.nodes.size());
  for (const core::mesh::Node& node : mesh.nodes) nodes.push_back(node.address);
  auto made =
      std::make_unique<WireSource>(source.interface, std::move(nodes), loop, std::move(report));
  if (auto started = made->start(); !started) return std::unexpected(started.error());
  return made;
}

}  // namespace mlcca::net
