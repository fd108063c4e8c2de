// SPDX-License-Identifier: BSD-2-Clause
// Keeps the meshes of the description: their sources, what is known of their links, and when links
// become stale.
#pragma once
#include <systemd/sd-event.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "core/mesh/link_table.hpp"
#include "core/model/system.hpp"
#include "daemon/net/sources/source.hpp"

namespace mlcca {

/// Owns the sources of all meshes and their tables of links, and reports changes.
class Meshes {
 public:
  /// Receives what an operator should know: the network, one line, and whether it is a problem.
  using Report =
      std::function<void(const std::string& network, const std::string& line, bool problem)>;
  /// Called when the known links of a network have changed.
  using Changed = std::function<void(std::size_t network)>;
  using Open = std::function<decltype(net::open_source)>;

  /// `loop` must outlive this object.
  Meshes(sd_event* loop, Changed changed, Report report, Open open = net::open_source)
      : loop_(loop),
        changed_(std::move(changed)),
        report_(std::move(report)),
        open_(std::move(open)) {}

  /// Takes the meshes of a new description. What is known of a mesh that is described as before
  /// stays known, also what a source has said that the mesh had before. A source that cannot be
  /// opened is reported, and its links are unknown. `self` is the index of this gateway.
  void describe(const core::System& system, std::size_t self);

  /// Runs the loop until every source has reported once, for at most `limit_ns`, so that a daemon
  /// that starts again does not withdraw what it would grant a second later. The loop must have no
  /// event sources other than those of the meshes yet.
  void await_first_reports(std::uint64_t limit_ns, const std::function<void()>& step);

  /// nullptr if the network is not a mesh.
  [[nodiscard]] const core::mesh::LinkTable* table(std::size_t network) const;
  [[nodiscard]] const core::mesh::Mesh* mesh(std::size_t network) const;
  /// What keeps sources from knowing their links now, one line each.
  [[nodiscard]] std::vector<std::string> problems() const;

 private:
  /// Limits the lines that untrusted peers can cause in the log: ten lines at once, then one every
  /// 10 s.
  struct Lines {
    bool take(std::uint64_t now);
    std::uint64_t paid_until = 0;  ///< ns
  };
  struct Entry {
    std::string name;
    std::size_t network = 0;
    core::mesh::Mesh mesh;
    std::optional<std::uint32_t> here;
    core::mesh::LinkTable table;
    std::vector<bool> reported;         // per source
    std::vector<std::string> problems;  // per source, as last reported
    std::vector<Lines> lines;           // per source
    std::vector<std::unique_ptr<net::LinkSource>> sources;
  };
  static void hand_over(const Entry& former, Entry& entry);
  static std::string problem_line(const Entry& entry, std::size_t source,
                                  const std::string& problem);
  void take_described(Entry& entry, std::size_t source);
  void open_sources(Entry& entry);
  void take(Entry& entry, std::size_t source, const core::mesh::Snapshot& snapshot);
  void expire();
  void arm();

  using Timer = std::unique_ptr<sd_event_source, FreeWith<sd_event_source_unref>>;
  sd_event* loop_;
  Changed changed_;
  Report report_;
  Open open_;
  std::vector<std::unique_ptr<Entry>> entries_;
  Timer timer_;
};

}  // namespace mlcca
