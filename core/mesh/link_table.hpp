// SPDX-License-Identifier: BSD-2-Clause
// Derives the believed graph of a mesh from the reports of its sources.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/mesh/belief.hpp"
#include "core/mesh/graph.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/sample.hpp"

namespace mlcca::core::mesh {

inline constexpr std::size_t kMaxNodes = 4096;
inline constexpr std::size_t kMaxLinks = 8192;  ///< directions, over all sources

/// What one source reports of a link, and what is believed of that link.
struct Known {
  Sample sample;
  Value believed_rate = 0;  ///< bit/s; 0: the link carries nothing
  Lack lack = Lack::gone;   ///< the reason if it carries nothing
  bool stale = false;
  std::size_t source = 0;  ///< index into Mesh::sources
};

/// Combines the reports of all sources into one graph. Times are CLOCK_MONOTONIC in ns and never
/// decrease.
///
/// If several sources know a direction, the rate is that of the best kind (effective, then derived,
/// then PHY), among equal kinds the youngest; the description's only if no other source knows one.
/// Loss and busy time are the worst that any source reports. The channel is that of the rate's
/// source, otherwise of the first that states one. A source without rates (an ETX protocol) thus
/// refines the loss of a link. Weights are comparable only within one source, so all are taken from
/// the first source that has any. Next hops are those of the first source that knows one.
///
/// Whether a link is present is decided by the sources that would know (core/mesh/roles.hpp): the
/// mesh's own protocol, otherwise the interfaces of this machine. If one of them would know and
/// none reports the link, it carries nothing, whoever states a rate.
///
/// A lower rate, higher loss or higher busy time counts at once. Better values count after they
/// have lasted Mesh::hold_up without interruption (ten times that within Mesh::tolerance), and then
/// as the worst seen in that time. A link that was unknown counts at once, unless it was lost less
/// than hold_up ago. Samples older than Mesh::stale_after or their own validity do not count, nor
/// do next hops of a source that is silent for so long; but their loss and busy time count until
/// the source reports something else without a problem. The description never ages.
class LinkTable {
 public:
  /// Described nodes keep their indices; other addresses get indices behind them. A described node
  /// without an address is known by its name. `here`: the node of this machine.
  explicit LinkTable(const Mesh& mesh, std::optional<std::uint32_t> here = std::nullopt);

  /// Takes the report of the source with that index in Mesh::sources. Returns true if graph()
  /// changed. What exceeds kMaxNodes or kMaxLinks is ignored and stated in problem(). Links between
  /// described nodes displace others, and nodes that no source reports any more are removed.
  bool take(std::size_t source, const Snapshot& snapshot, std::uint64_t now);
  /// Applies what has become too old, and improvements that have lasted. Returns true if graph()
  /// changed.
  bool expire(std::uint64_t now);
  /// The next time at which expire() must be called; kUnbounded: never.
  [[nodiscard]] std::uint64_t next_deadline() const { return deadline_; }

  [[nodiscard]] const Graph& graph() const { return graph_; }
  /// The address of a node of graph().
  [[nodiscard]] const std::string& address(std::uint32_t node) const { return addresses_[node]; }
  /// The node of graph() with that address; nullopt if there is none.
  [[nodiscard]] std::optional<std::uint32_t> node(const std::string& address) const;
  /// What keeps a source from knowing all links, as text; empty if nothing does.
  [[nodiscard]] const std::string& problem(std::size_t source) const;
  /// All reports that are kept, as of the last take() or expire(). Withdrawn ones (sample.rate 0)
  /// are among them: a report names the links that carry nothing, and a reload keeps the loss that
  /// a source has warned of.
  [[nodiscard]] std::vector<Known> links() const;
  /// The number of entries of links().
  [[nodiscard]] std::size_t size() const;

 private:
  using Ends = std::pair<std::uint32_t, std::uint32_t>;
  struct Report {
    std::size_t source = 0;
    std::uint64_t round = 0;  ///< number of the take() that brought it
    Sample sample;
    bool withdrawn = false;  ///< only its loss and busy time count, see drop_old_rounds()
  };
  struct Entry {
    std::vector<Report> reports;
    Belief belief;
  };
  struct SourceState {
    std::uint64_t rounds = 0;
    std::uint64_t reported = 0;
    std::vector<NextHopIndex> next_hops;
    std::string problem;
  };

  [[nodiscard]] bool is_description(std::size_t source) const;
  [[nodiscard]] std::uint64_t fresh_until(const Report& report) const;
  [[nodiscard]] std::uint64_t routes_fresh_until(std::size_t source) const;
  [[nodiscard]] bool is_fresh(const Report& r) const { return now_ <= fresh_until(r); }

  [[nodiscard]] bool is_described(std::uint32_t node) const { return node < mesh_.nodes.size(); }
  std::optional<std::uint32_t> node_for(const std::string& address);
  void forget_unused_nodes();
  void forget_links_of_undescribed_nodes();
  bool enter(std::size_t source, const Sample& sample);
  bool enter_next_hop(SourceState& state, const NextHop& hop);
  void drop_old_rounds(std::size_t source);

  [[nodiscard]] bool is_preferred(const Report& a, const Report& b) const;
  [[nodiscard]] bool is_there(const Report& r) const { return is_fresh(r) && !r.withdrawn; }
  [[nodiscard]] bool is_absent(const Ends& ends, const Entry& entry) const;
  [[nodiscard]] Lack lack_of(const Ends& ends, const Entry& entry) const;
  [[nodiscard]] std::optional<Observation> observe(const Ends& ends, const Entry& entry) const;
  [[nodiscard]] std::optional<std::size_t> weighing_source() const;
  [[nodiscard]] std::vector<NextHopIndex> next_hops() const;
  [[nodiscard]] Graph believed() const;
  [[nodiscard]] std::uint64_t earliest_deadline() const;
  bool update_beliefs();

  Mesh mesh_;
  std::optional<std::uint32_t> here_;
  std::vector<std::string> addresses_;  ///< per node
  std::unordered_map<std::string, std::uint32_t> nodes_;
  std::map<Ends, Entry> entries_;
  std::vector<SourceState> sources_;
  Graph graph_;
  std::uint64_t now_ = 0;
  std::uint64_t deadline_ = kUnbounded;
};

/// The described links in the form in which a source reports them.
[[nodiscard]] Snapshot described_snapshot(const Mesh& mesh, std::uint64_t now);

}  // namespace mlcca::core::mesh
