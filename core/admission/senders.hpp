// SPDX-License-Identifier: BSD-2-Clause
// Detects two senders of the same frames. On a CAN bus each identifier may have one sender only:
// two that start at the same moment destroy each other's frames, and no bound of the analysis
// holds. Where frames carry the subject, an event that two devices send arrives twice.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "core/model/members.hpp"
#include "core/model/system.hpp"
#include "core/profiles/profile.hpp"

namespace mlcca::core {

/// A device that sends on a network: the index of a gateway, or kOwn plus the index of a publisher
/// that is on the network itself.
using Device = std::uint64_t;
inline constexpr Device kOwn = Device{1} << 32U;

/// Records which device sends the frames of each granted delivery of one channel, per network.
class Senders {
 public:
  /// Keeps references to both arguments.
  Senders(const System& system, const Members& members) : system_(system), members_(members) {}

  /// Two devices that would send the same frames on `network`.
  struct Conflict {
    Place network;
    Device first = 0;  ///< the device that was added before
    Device other = 0;
  };
  /// The conflict on the route with a device that was added before; nullopt if there is none. A bus
  /// is reported before other networks. Two publishers on one bus are no conflict here: rules of
  /// the description make sure that their frames differ.
  [[nodiscard]] std::optional<Conflict> conflict(std::size_t publisher, const Route& route) const {
    std::optional<Conflict> out;
    if (device_of_.empty()) return out;  // the usual case: the channel has one delivery
    each(publisher, route, [&](Place network, std::size_t name, Device device) {
      const auto known = device_of_.find({network.index, name});
      if (known == device_of_.end() || known->second == device) return;
      if (out && (is_bus(out->network) || !is_bus(network))) return;
      if (known->second < kOwn || device < kOwn) out = Conflict{network, known->second, device};
    });
    return out;
  }

  /// Adds the senders of a granted delivery. If a network has one already, that one stays.
  void add(std::size_t publisher, const Route& route) {
    each(publisher, route, [this](Place network, std::size_t name, Device device) {
      device_of_.try_emplace({network.index, name}, device);
    });
  }

 private:
  [[nodiscard]] bool is_bus(Place network) const {
    return system_.networks[network.index].kind == NetworkKind::can;
  }
  /// Calls `sends` for each network of the route with the key that frames of one sender share: on a
  /// bus the node number (0 where the profile has none), elsewhere the publisher.
  void each(std::size_t publisher, const Route& route, auto sends) const {
    for (std::size_t i = 0; i < route.size(); ++i) {
      if (route[i].kind != Place::Kind::network) continue;
      const Network& network = system_.networks[route[i].index];
      if (!is_bus(route[i]) && !network.carries_subjects()) continue;
      std::size_t name = publisher;
      if (is_bus(route[i]))
        name = has_nodes(network.profile) ? members_.publisher(publisher).node.value_or(0) : 0;
      sends(route[i], name, i == 0 ? kOwn + publisher : Device{route[i - 1].index});
    }
  }

  const System& system_;
  const Members& members_;
  std::map<std::pair<std::size_t, std::size_t>, Device> device_of_;
};

}  // namespace mlcca::core
