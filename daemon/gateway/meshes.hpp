// SPDX-License-Identifier: BSD-2-Clause
// The meshes of the description: their sources, what is believed of their links, and when that has
// to be evaluated again.
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

class Meshes {
 public:
  /// Gets what an operator should know: network, one line, whether it is a problem.
  using Report =
      std::function<void(const std::string& network, const std::string& line, bool problem)>;
  /// The links of a network are believed to be others than before.
  using Changed = std::function<void(std::size_t network)>;
  using Open = std::function<decltype(net::open_source)>;

  /// `loop` must outlive this.
  Meshes(sd_event* loop, Changed changed, Report report, Open open = net::open_source)
      : loop_(loop),
        changed_(std::move(changed)),
        report_(std::move(report)),
        open_(std::move(open)) {}

  /// The meshes of a new description. What is known of a mesh that is described as before stays
  /// known, and what a source has said that is among those of the mesh as before. A source that
  /// cannot be opened is reported and knows nothing. `self`: the gateway of this machine.
  void describe(const core::System& system, std::size_t self);

  /// Runs the loop until every source has reported once, at most `limit_ns`: a daemon that starts
  /// again should not withdraw what it will grant in a second. Nothing but sources may be on the
  /// loop yet.
  void await_first_reports(std::uint64_t limit_ns, const std::function<void()>& step);

  /// Null: no mesh.
  [[nodiscard]] const core::mesh::LinkTable* table(std::size_t network) const;
  [[nodiscard]] const core::mesh::Mesh* mesh(std::size_t network) const;
  /// What keeps sources from knowing their links now, a line each.
  [[nodiscard]] std::vector<std::string> problems() const;

 private:
  /// What untrusted peers make a source say must not fill the log: ten lines at once, then one in
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
