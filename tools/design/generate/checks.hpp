// SPDX-License-Identifier: BSD-2-Clause
// Selects the checks that the compiler makes for a unit: the pairs of ends, the hops between them,
// and the refusals that only the core can find.
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

/// A hop of a route: a network or gateway and its effective provision.
struct RouteHop {
  core::Place place;
  Hop gives;
  bool granted = true;
  bool late = false;  ///< refused there by a CAN bus; `gives` is the bound that it would be held
                      ///< to, not a response time
  bool left = false;  ///< refused there by a mesh; the Bandwidth in `gives` is what other channels
                      ///< leave
};

/// What `mlccactl check` decides about a system, for every attribute set.
class Decisions {
 public:
  /// `system` must have sorted bindings.
  explicit Decisions(const core::System& system);

  /// A delivery in one attribute set.
  struct Delivery {
    std::vector<RouteHop> hops;  ///< empty if both ends are on one gateway or there is an obstacle
    bool granted = false;
    /// The errors (not warnings) of the channel in that set.
    std::shared_ptr<const std::vector<core::Finding>> errors;
  };
  /// The delivery from a publisher to all subscribers at a place, in the attribute set `set`.
  [[nodiscard]] const Delivery& of(std::size_t publisher, core::Place to, std::size_t set) const {
    return deliveries_.at({publisher, to, set});
  }
  /// The attribute set that a channel uses if all best cases are real.
  [[nodiscard]] std::size_t set_of(std::size_t channel) const { return sets_.at(channel); }
  /// Whether it depends on best cases, and so on the run time, which set a channel uses.
  [[nodiscard]] bool has_open_set(std::size_t channel) const { return open_sets_.at(channel); }
  /// The publishers and subscribers of each channel.
  [[nodiscard]] const core::Members& members() const { return members_; }
  /// The errors of a channel in the set that it uses.
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

/// A publisher and a subscriber of the same channel, at least one of them in the unit. Only one end
/// if the system has none on the other side.
struct Pair {
  std::optional<End> publisher;
  std::optional<End> subscriber;
};

/// All pairs of a unit, in the order of its ends; `members` are those of the system.
std::vector<Pair> pairs_of(const core::System& system, const core::Members& members,
                           const Unit& unit);

/// Whether the compile-time checks (static_check.hpp) refuse a pair in an attribute set over these
/// hops.
[[nodiscard]] bool is_refused_by_types(const core::System& system, std::size_t publisher,
                                       std::size_t subscriber, std::size_t set,
                                       const std::vector<RouteHop>& hops);

/// The reason, "MLCCA024: …", why the core refuses a pair that the compile-time checks accept.
[[nodiscard]] std::string refusal_of(const core::System& system,
                                     const std::vector<core::Finding>& errors,
                                     std::size_t publisher, std::size_t subscriber);

}  // namespace mlcca::tools::design
