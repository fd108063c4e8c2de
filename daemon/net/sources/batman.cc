// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/sources/batman.hpp"

#include <linux/batman_adv.h>
#include <netlink/attr.h>
#include <netlink/netlink.h>

#include <algorithm>
#include <cerrno>
#include <map>
#include <utility>

#include "daemon/net/sources/kernel_source.hpp"

namespace mlcca::net {
namespace batman {
namespace {

using core::mesh::RateKind;

constexpr std::uint64_t kNanosPerMilli = 1'000'000;
constexpr std::uint64_t kBestQuality = 255;

std::optional<genl::Attributes> attributes_of(genl::Octets octets, std::uint8_t command) {
  auto message = genl::read_message(octets);
  if (!message || message->command != command) return {};
  return message->attributes;
}

/// The hard interface with this index; nullptr if it has gone meanwhile.
const HardInterface* interface_of(const Seen& seen, std::uint32_t index) {
  const auto it = std::ranges::find(seen.interfaces, index, &HardInterface::index);
  return it == seen.interfaces.end() ? nullptr : &*it;
}

std::uint64_t time_before(std::uint64_t now, std::uint32_t millis) {
  return now - std::min(now, millis * kNanosPerMilli);
}

using Way = std::pair<std::string, std::uint32_t>;  ///< a neighbour, and the interface to it

/// TQ is the share of packets that get through and are answered, for both directions together. So
/// the loss of one direction is not greater; in 1e-9.
std::map<Way, Value> losses_of(const Seen& seen) {
  std::map<Way, Value> out;
  for (const Originator& direct : seen.originators)
    if (direct.mac == direct.next_hop && direct.quality)
      out.try_emplace({direct.mac, direct.interface},
                      (kBestQuality - *direct.quality) * 1'000'000'000 / kBestQuality);
  return out;
}

}  // namespace

std::optional<HardInterface> read_hard_interface(genl::Octets message) {
  const auto attributes = attributes_of(message, BATADV_CMD_GET_HARDIF);
  if (!attributes) return {};
  const auto index = attributes->u32(BATADV_ATTR_HARD_IFINDEX);
  auto mac = attributes->mac(BATADV_ATTR_HARD_ADDRESS);
  if (!index || !mac) return {};
  return HardInterface{.index = *index, .mac = std::move(*mac)};
}

std::optional<Neighbour> read_neighbour(genl::Octets message) {
  const auto attributes = attributes_of(message, BATADV_CMD_GET_NEIGHBORS);
  if (!attributes) return {};
  const auto interface = attributes->u32(BATADV_ATTR_HARD_IFINDEX);
  const auto last_seen = attributes->u32(BATADV_ATTR_LAST_SEEN_MSECS);
  auto mac = attributes->mac(BATADV_ATTR_NEIGH_ADDRESS);
  if (!interface || !last_seen || !mac) return {};
  Neighbour out{
      .mac = std::move(*mac), .interface = *interface, .throughput = {}, .last_seen = *last_seen};
  // kbit/s here, unlike the gateway list and the override, which use 100 kbit/s.
  if (const auto kbits = attributes->u32(BATADV_ATTR_THROUGHPUT))
    out.throughput = Value{*kbits} * 1000;
  return out;
}

std::optional<Originator> read_originator(genl::Octets message) {
  const auto attributes = attributes_of(message, BATADV_CMD_GET_ORIGINATORS);
  if (!attributes) return {};
  const auto interface = attributes->u32(BATADV_ATTR_HARD_IFINDEX);
  auto mac = attributes->mac(BATADV_ATTR_ORIG_ADDRESS);
  auto next_hop = attributes->mac(BATADV_ATTR_NEIGH_ADDRESS);
  if (!interface || !mac || !next_hop) return {};
  return Originator{.mac = std::move(*mac),
                    .next_hop = std::move(*next_hop),
                    .interface = *interface,
                    .best = attributes->has(BATADV_ATTR_FLAG_BEST),
                    .quality = attributes->u8(BATADV_ATTR_TQ),
                    .last_seen = attributes->u32(BATADV_ATTR_LAST_SEEN_MSECS).value_or(0)};
}

core::mesh::Snapshot view(const Seen& seen, std::uint64_t now) {
  core::mesh::Snapshot out;
  const auto losses = losses_of(seen);
  for (const Neighbour& neighbour : seen.neighbours) {
    const HardInterface* const own = interface_of(seen, neighbour.interface);
    if (own == nullptr) continue;
    core::mesh::Sample sample;
    sample.from = own->mac;
    sample.to = neighbour.mac;
    sample.rate = neighbour.throughput.value_or(0);
    sample.kind = RateKind::effective;
    const auto loss = losses.find({neighbour.mac, neighbour.interface});
    if (loss != losses.end()) sample.loss = loss->second;
    sample.taken = time_before(now, neighbour.last_seen);
    // What was received from the neighbour came over the other direction. Only the neighbour knows
    // the rate of that.
    core::mesh::Sample back;
    back.from = sample.to;
    back.to = sample.from;
    back.taken = sample.taken;
    out.links.push_back(std::move(sample));
    out.links.push_back(std::move(back));
  }
  for (const Originator& way : seen.originators) {
    const HardInterface* const own = way.best ? interface_of(seen, way.interface) : nullptr;
    if (own != nullptr)
      out.next_hops.push_back({.from = own->mac, .to = way.mac, .via = way.next_hop});
  }
  return out;
}

}  // namespace batman

namespace {

class BatmanSource : public KernelSource {
 public:
  BatmanSource(std::string interface, sd_event* loop, Report report)
      : KernelSource(loop, std::move(report)), interface_(std::move(interface)) {}

 private:
  void poll() override {
    seen_ = {};
    ask_family(BATADV_NL_NAME, interface_,
               [this](Conversation& kernel, std::uint16_t family, unsigned index) {
                 index_ = index;
                 ask_all(kernel, family);
               });
  }

  /// Requests a dump. `read` turns each message into an entry of `into`.
  template <class T>
  void ask(Conversation& kernel, std::uint16_t family, std::uint8_t command,
           std::optional<T> (*read)(genl::Octets), std::vector<T>& into,
           Conversation::OnEnd end) const {
    auto request = Conversation::generic_request(family, command, NLM_F_DUMP);
    if (request) nla_put_u32(request.get(), BATADV_ATTR_MESH_IFINDEX, index_);
    kernel.ask(
        std::move(request),
        [read, &into](genl::Octets octets) {
          if (auto entry = read(octets)) into.push_back(std::move(*entry));
        },
        std::move(end));
  }

  void ask_all(Conversation& kernel, std::uint16_t family) {
    const auto refused = [this](int error) {
      // Without a hard interface the kernel has no neighbours to list (ENOENT).
      if (error == ENOENT && seen_.interfaces.empty()) {
        report_problem(interface_ + " has no interface below it");
        return;
      }
      if (error != 0) report_refusal("batman-adv on " + interface_, error);
    };
    ask(kernel, family, BATADV_CMD_GET_HARDIF, batman::read_hard_interface, seen_.interfaces,
        refused);
    ask(kernel, family, BATADV_CMD_GET_NEIGHBORS, batman::read_neighbour, seen_.neighbours,
        refused);
    ask(kernel, family, BATADV_CMD_GET_ORIGINATORS, batman::read_originator, seen_.originators,
        [this, refused](int error) {
          if (error != 0) {
            refused(error);
            return;
          }
          report(batman::view(seen_, now()));
        });
  }

  std::string interface_;
  unsigned index_ = 0;
  batman::Seen seen_;
};

}  // namespace

Result<std::unique_ptr<LinkSource>> open_batman(const core::mesh::Source& source, sd_event* loop,
                                                LinkSource::Report report) {
  if (source.interface.empty()) return fail("a source batman needs the name of a mesh interface");
  auto made = std::make_unique<BatmanSource>(source.interface, loop, std::move(report));
  if (auto started = made->start(); !started) return std::unexpected(started.error());
  return made;
}

}  // namespace mlcca::net
