// SPDX-License-Identifier: BSD-2-Clause
// The networks as they are now: what can be used, at which bit rate, over which links.
#pragma once
#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/can/frame.hpp"
#include "core/can/message.hpp"
#include "core/mesh/domains.hpp"
#include "core/mesh/evaluation.hpp"
#include "core/mesh/link_table.hpp"
#include "core/mesh/route.hpp"
#include "core/model/system.hpp"
#include "core/reserve/ledger.hpp"
#include "core/reserve/parts.hpp"

namespace mlcca::core {

/// The load of a publisher that sends on its bus although nothing is granted to it.
struct ObservedLoad {
  std::size_t publisher = 0;
  std::uint32_t load = 0;  ///< 1e-6 of the bus time
  bool operator==(const ObservedLoad&) const = default;
};

/// A channel whose binding on a network is not to be relied on: the broker has said otherwise.
struct Contradicted {
  std::size_t channel = 0;
  std::string how;  ///< as a clause
  bool operator==(const Contradicted&) const = default;
};

/// What is known of a network now. A network that this gateway does not touch is taken as
/// described.
struct Condition {
  bool available = true;
  std::string problem;           ///< why not, in words
  can::Timing timing;            ///< of a CAN bus, 0: as described
  std::uint32_t background = 0;  ///< of a CAN bus: unaccounted load in 1e-6 of its time: what was
                                 ///< measured in excess of what is reserved, that of `observed`
                                 ///< included
  /// To itself none of them is unaccounted load: what it sends is analysed where it is decided.
  std::vector<ObservedLoad> observed;
  std::vector<Contradicted> contradicted;  ///< sorted by channel
  [[nodiscard]] const Contradicted* contradiction_of(std::size_t channel) const {
    const auto it = std::ranges::lower_bound(contradicted, channel, {}, &Contradicted::channel);
    return it != contradicted.end() && it->channel == channel ? &*it : nullptr;
  }
  bool operator==(const Condition&) const = default;
};

/// A mesh as its links are believed to be, with what follows from them.
class MeshView {
 public:
  /// `mesh` must outlive this. `node_addresses`: of the nodes of the graph. `before`: a view of the
  /// same links in another state, whose domains are taken over.
  MeshView(const mesh::Mesh& mesh, mesh::Graph links, std::vector<std::string> node_addresses = {},
           const MeshView* before = nullptr);
  MeshView(const MeshView&) = delete;
  MeshView& operator=(const MeshView&) = delete;
  MeshView(MeshView&&) = delete;
  MeshView& operator=(MeshView&&) = delete;
  ~MeshView() = default;

  /// Indices into the graph's links; empty: no path.
  [[nodiscard]] const std::vector<std::uint32_t>& path(std::uint32_t from, std::uint32_t to) const {
    return paths_.between(from, to);
  }

  /// The cost of the path between two nodes that have one.
  [[nodiscard]] const mesh::PathCost& cost(std::uint32_t from, std::uint32_t to) const;

  /// Where no path leads there: what links that would lead there lack; see lacking_from().
  [[nodiscard]] std::optional<mesh::Lack> lack(std::uint32_t from, std::uint32_t to) const;

  /// As described, or else its address.
  [[nodiscard]] std::string node_name(std::uint32_t node) const;
  [[nodiscard]] std::string domain_name(std::size_t domain) const;

  mesh::Graph graph;
  std::vector<std::string> addresses;  ///< of nodes, as far as they are known
  [[nodiscard]] const mesh::Domains& domains() const { return *domains_; }
  /// Medium time of each domain that others take, ps/s.
  std::vector<Value> background;

 private:
  const mesh::Mesh* mesh_;
  std::shared_ptr<const mesh::Domains> domains_;
  // The result of a search is remembered.
  mutable mesh::Paths paths_;
  mutable std::unordered_map<std::uint64_t, mesh::PathCost> costs_;
  mutable std::unordered_map<std::uint32_t, std::vector<std::optional<mesh::Lack>>> lacking_;
};

/// One entry for each network, and for each gateway.
struct World {
  World() = default;
  explicit World(const System& system)
      : conditions(system.networks.size()),
        meshes(system.networks.size()),
        failed(system.gateways.size(), false),
        foreign(system.networks.size()),
        shared(shared_networks(system)) {}

  std::vector<Condition> conditions;
  /// Empty where the network is no mesh that is evaluated, or nothing is known of it.
  std::vector<std::shared_ptr<const MeshView>> meshes;
  /// By gateway: one that announces itself and is not there, so that others take its place.
  std::vector<bool> failed;
  /// What other gateways have reserved, where many gateways use one store; else nothing.
  std::vector<cluster::Foreign> foreign;
  /// By network: several gateways have a port there.
  std::vector<bool> shared;
  /// Gateways are elected by that store, in place of announcing themselves.
  bool elects = false;
};

/// Everything as described: meshes have the described links.
[[nodiscard]] World described_world(const System& system);

/// What the analysis of a network's bus assumes; nothing where it is not analysed: no CAN bus, or
/// its bit rate is not known.
[[nodiscard]] std::optional<can::Assumptions> bus_of(const System& system,
                                                     const Condition& condition,
                                                     std::size_t network);

/// Whether that traffic, as that gateway has reserved it, counts with a publisher that is there.
using CountsWithPublisher = std::function<bool(std::size_t gateway, const cluster::Source&)>;

/// What others hold of a network, in numbers of its bus and its links as they are: without the
/// traffic of described publishers, which is the same whoever has reserved it, and of others that
/// are there. `view`: of a mesh, null where nothing is known of it.
[[nodiscard]] Others others_on(const System& system, const World& world, std::size_t network,
                               const MeshView* view, const CountsWithPublisher& counts = {});

/// What paths of one flow take of the domains of a mesh; nothing where a path is not known.
[[nodiscard]] std::optional<std::vector<mesh::Share>> shares_of(
    const mesh::Mesh& mesh, const MeshView& view, std::span<const cluster::PathPart> paths);

/// What is promised twice from one node to another counts once: for more, in smaller events.
void join(std::vector<cluster::PathPart>& paths, const cluster::PathPart& path);
/// The same of paths that were put together so. A link that several of them go over counts for the
/// one that takes most.
[[nodiscard]] std::optional<std::vector<mesh::Share>> shares_of_joined(
    const mesh::Mesh& mesh, const MeshView& view, std::vector<cluster::PathPart> paths);

/// A ledger in which nothing is promised to what is decided here, for that world.
[[nodiscard]] Ledger empty_ledger(const System& system, const World& world);

/// Number of a gateway's queue among the Assumptions of bus_of(); can::kOwnQueue where it has no
/// port there.
[[nodiscard]] std::uint32_t queue_of(const System& system, std::size_t gateway,
                                     std::size_t network);

}  // namespace mlcca::core
