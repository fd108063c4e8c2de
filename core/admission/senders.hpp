// SPDX-License-Identifier: BSD-2-Clause
// Who puts the frames of a channel on each CAN bus. Frames of one identifier have one sender there:
// two that start at once destroy each other's frames, and no bound of the analysis holds.
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

/// A device on a bus: a gateway by its number, or a publisher on the bus itself from kOwn on.
using Device = std::uint64_t;
inline constexpr Device kOwn = Device{1} << 32U;

class Senders {
 public:
  /// Both must outlive this.
  Senders(const System& system, const Members& members) : system_(system), members_(members) {}

  struct Conflict {
    Place bus;
    Device first = 0;  ///< that was added
    Device other = 0;
  };
  /// The first bus of the route where another device has been added for this publisher's frames.
  /// Publishers on one bus are told apart by the rules of the description.
  [[nodiscard]] std::optional<Conflict> conflict(std::size_t publisher, const Route& route) const {
    std::optional<Conflict> out;
    if (device_of_.empty()) return out;  // mostly: a channel has one delivery
    each(publisher, route, [&](Place bus, std::uint8_t node, Device device) {
      const auto known = device_of_.find({bus.index, node});
      if (out || known == device_of_.end() || known->second == device) return;
      if (known->second < kOwn || device < kOwn) out = Conflict{bus, known->second, device};
    });
    return out;
  }

  /// Those of a delivery that is granted. Of two on one bus the first one stays.
  void add(std::size_t publisher, const Route& route) {
    each(publisher, route, [this](Place bus, std::uint8_t node, Device device) {
      device_of_.try_emplace({bus.index, node}, device);
    });
  }

 private:
  /// Calls `sends` for each bus of the route. Where the profile has nodes, frames name theirs.
  void each(std::size_t publisher, const Route& route, auto sends) const {
    for (std::size_t i = 0; i < route.size(); ++i) {
      if (route[i].kind != Place::Kind::network) continue;
      const Network& network = system_.networks[route[i].index];
      if (network.kind != NetworkKind::can) continue;
      const bool named = has_nodes(network.profile);
      sends(route[i], named ? members_.publisher(publisher).node.value_or(0) : std::uint8_t{0},
            i == 0 ? kOwn + publisher : Device{route[i - 1].index});
    }
  }

  const System& system_;
  const Members& members_;
  std::map<std::pair<std::size_t, std::uint8_t>, Device> device_of_;
};

}  // namespace mlcca::core
