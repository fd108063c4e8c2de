// SPDX-License-Identifier: BSD-2-Clause
// What sources report of links becomes what is believed of them: worse at once, better once it has
// lasted, and nothing of what is too old.
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

/// What one source says of a link, and what is believed of that link.
struct Known {
  Sample sample;
  Value believed_rate = 0;  ///< bit/s; 0: the link carries nothing
  Lack lack = Lack::gone;   ///< why it carries nothing
  bool stale = false;
  std::size_t source = 0;  ///< index into Mesh::sources
};

/// Times are CLOCK_MONOTONIC ns and never go back.
///
/// Where several sources know a direction: the rate is that of the best kind (effective, then
/// derived, then PHY), of equal kinds the youngest, and the description's where no other knows one;
/// loss and busy are the worst that anyone
/// reports; the channel is that of the rate's source, or else of the first one that says it. A
/// source that knows no rate (an ETX protocol) so refines the loss of a link whose rate another one
/// knows. Weights are compared with each other, so they are all of one source, the first that gives
/// any; next hops are those of the first source that knows one.
///
/// Whether a link is there is asked of those who would know (core/mesh/roles.hpp): the mesh's own
/// protocol, or else the interfaces of this machine. Where one of them would know and none of them
/// says so, the link carries nothing, whoever gives a rate to it.
///
/// A lower rate, a higher loss, a higher busy time count at once. Better ones count once they have
/// lasted Mesh::hold_up without interruption, and then as the worst that was seen in that time; an
/// improvement within Mesh::tolerance of what is believed is none. A link that was unknown counts
/// at once, unless it was lost less than hold_up ago: then it must last, too. Samples older than
/// Mesh::stale_after, or than their own validity, are as good as none, and so are the next hops of
/// a source that has not reported for so long; but the loss and busy time in them count until the
/// source reports something else without a problem. What the description says never ages.
class LinkTable {
 public:
  /// Nodes keep their indices of the description; other addresses become nodes behind them. A
  /// described node without an address is known by its name. `here`: the node of this machine.
  explicit LinkTable(const Mesh& mesh, std::optional<std::uint32_t> here = std::nullopt);

  /// `source` is an index into Mesh::sources. True if graph() changed. What exceeds kMaxNodes or
  /// kMaxLinks is ignored and stated in problem(). Links between described nodes take the room of
  /// others, and nodes that no source reports any more give theirs.
  bool take(std::size_t source, const Snapshot& snapshot, std::uint64_t now);
  /// What became too old, and improvements that have lasted. True if graph() changed.
  bool expire(std::uint64_t now);
  /// When expire() has something to do; kUnbounded: never.
  [[nodiscard]] std::uint64_t next_deadline() const { return deadline_; }

  [[nodiscard]] const Graph& graph() const { return graph_; }
  /// Of a node of graph().
  [[nodiscard]] const std::string& address(std::uint32_t node) const { return addresses_[node]; }
  [[nodiscard]] std::optional<std::uint32_t> node(const std::string& address) const;
  /// What keeps a source from knowing (all) links; empty: nothing.
  [[nodiscard]] const std::string& problem(std::size_t source) const;
  /// Everything that was reported and is not gone, as of the last take() or expire().
  [[nodiscard]] std::vector<Known> links() const;
  /// As many as links() gives.
  [[nodiscard]] std::size_t size() const;

 private:
  using Ends = std::pair<std::uint32_t, std::uint32_t>;
  struct Report {
    std::size_t source = 0;
    std::uint64_t round = 0;  ///< which take() of the source it is from
    Sample sample;
    bool withdrawn = false;  ///< not said any more: only what it warns of counts
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
  bool settle();

  Mesh mesh_;
  std::optional<std::uint32_t> here_;
  std::vector<std::string> addresses_;  ///< of each node
  std::unordered_map<std::string, std::uint32_t> nodes_;
  std::map<Ends, Entry> entries_;
  std::vector<SourceState> sources_;
  Graph graph_;
  std::uint64_t now_ = 0;
  std::uint64_t deadline_ = kUnbounded;
};

/// The described links as a source reports them.
[[nodiscard]] Snapshot described_snapshot(const Mesh& mesh, std::uint64_t now);

}  // namespace mlcca::core::mesh
