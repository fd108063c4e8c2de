// SPDX-License-Identifier: BSD-2-Clause
// Which checks the compiler shall make for a unit: between whom, over which hops, and what only the
// core can refuse.
#pragma once
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "core/design/findings.hpp"
#include "core/model/members.hpp"
#include "core/model/topology.hpp"
#include "mlcca/compose.hpp"
#include "tools/design/generate/unit.hpp"

namespace mlcca::tools::design {

/// A network or gateway that events cross, and what it gives them: stated, or computed.
struct RouteHop {
  core::Place place;
  Hop gives;
  bool granted = true;
  bool late = false;  ///< refused there: a bus gives what it would be held to, and no response time
  bool left = false;  ///< refused there: the Bandwidth of a mesh is what other channels leave
};

/// What `mlccactl check` decides about a whole system, in every attribute set.
class Decisions {
 public:
  /// `system` has sorted bindings.
  explicit Decisions(const core::System& system);

  struct Delivery {
    std::vector<RouteHop> hops;  ///< empty: both on one gateway, or an obstacle
    bool granted = false;
    /// Of the channel in that set; errors alone.
    std::shared_ptr<const std::vector<core::Finding>> errors;
  };
  /// From a publisher to all subscribers at a place.
  [[nodiscard]] const Delivery& of(std::size_t publisher, core::Place to, std::size_t set) const {
    return deliveries_.at({publisher, to, set});
  }
  /// The attribute set that a channel uses, if all best cases hold.
  [[nodiscard]] std::size_t set_of(std::size_t channel) const { return sets_.at(channel); }
  /// Which set it uses is decided at run time: it depends on which best cases hold.
  [[nodiscard]] bool has_open_set(std::size_t channel) const { return open_sets_.at(channel); }
  /// Who publishes and who subscribes each channel.
  [[nodiscard]] const core::Members& members() const { return members_; }
  /// Errors of a channel in the set that it uses.
  [[nodiscard]] const std::vector<core::Finding>& errors_of(std::size_t channel) const {
    return *errors_.at(channel);
  }

 private:
  core::Members members_;
  std::map<std::tuple<std::size_t, core::Place, std::size_t>, Delivery> deliveries_;
  std::vector<std::size_t> sets_;
  std::vector<bool> open_sets_;
  std::vector<std::shared_ptr<const std::vector<core::Finding>>> errors_;
};

/// A publisher and a subscriber of the same channel, one of them of the unit; or one end alone,
/// where the system has no endpoint on the other side.
struct Pair {
  std::optional<End> publisher;
  std::optional<End> subscriber;
};

/// All of a unit, in the order of its ends. `members` are those of the system.
std::vector<Pair> pairs_of(const core::System& system, const core::Members& members,
                           const Unit& unit);

/// Whether the checks of static_check.hpp refuse a pair in an attribute set, over these hops.
[[nodiscard]] bool is_refused_by_types(const core::System& system, std::size_t publisher,
                                       std::size_t subscriber, std::size_t set,
                                       const std::vector<RouteHop>& hops);

/// Why a pair is refused that its own checks do not refuse: "MLCCA024: …".
[[nodiscard]] std::string refusal_of(const core::System& system,
                                     const std::vector<core::Finding>& errors,
                                     std::size_t publisher, std::size_t subscriber);

}  // namespace mlcca::tools::design
