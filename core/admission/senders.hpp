// SPDX-License-Identifier: BSD-2-Clause
// Who puts the frames of a channel on each network. On a CAN bus frames of one identifier have one
// sender: two that start at once destroy each other's frames, and no bound of the analysis holds.
// Where frames name the subject, an event of one publisher that two send arrives twice.
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

/// A device on a network: a gateway by its number, or a publisher on the network itself from kOwn
/// on.
using Device = std::uint64_t;
inline constexpr Device kOwn = Device{1} << 32U;

class Senders {
 public:
  /// Both must outlive this.
  Senders(const System& system, const Members& members) : system_(system), members_(members) {}

  struct Conflict {
    Place network;
    Device first = 0;  ///< that was added
    Device other = 0;
  };
  /// The first network of the route where another device has been added for this publisher's
  /// frames, a bus before others. Publishers on one bus are distinguished by the rules of the
  /// description.
  [[nodiscard]] std::optional<Conflict> conflict(std::size_t publisher, const Route& route) const {
    std::optional<Conflict> out;
    if (device_of_.empty()) return out;  // mostly: a channel has one delivery
    each(publisher, route, [&](Place network, std::size_t name, Device device) {
      const auto known = device_of_.find({network.index, name});
      if (known == device_of_.end() || known->second == device) return;
      if (out && (is_bus(out->network) || !is_bus(network))) return;
      if (known->second < kOwn || device < kOwn) out = Conflict{network, known->second, device};
    });
    return out;
  }

  /// Those of a delivery that is granted. Of two on one network the first one stays.
  void add(std::size_t publisher, const Route& route) {
    each(publisher, route, [this](Place network, std::size_t name, Device device) {
      device_of_.try_emplace({network.index, name}, device);
    });
  }

 private:
  [[nodiscard]] bool is_bus(Place network) const {
    return system_.networks[network.index].kind == NetworkKind::can;
  }
  /// Calls `sends` for each network of the route with what frames of one sender have in common: on
  /// a bus the node, where the profile has nodes, elsewhere the publisher.
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
