// SPDX-License-Identifier: BSD-2-Clause
// Random systems, and what check says of them.
#pragma once
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/design/inspect.hpp"
#include "core/model/system.hpp"
#include "description/read.hpp"
#include "tests/levels/random_system.hpp"

namespace mlcca::testing {

constexpr std::uint64_t kSystems = 6000;

using Delivery = std::tuple<std::size_t, std::size_t, core::Place>;  // channel, publisher, place

using OnBus = std::pair<std::size_t, std::uint64_t>;  // network, key

/// A mesh with nodes, and neither Link nor Source: MLCCA042.
inline bool has_no_links(const core::System& system, core::Place place) {
  if (place.kind != core::Place::Kind::network) return false;
  const auto& mesh = system.networks[place.index].mesh;
  return mesh && !mesh->nodes.empty() && mesh->links.empty() && mesh->sources.empty();
}

/// What check says of a system.
struct Checked {
  core::System system;
  core::Inspection inspection;
  std::map<Delivery, bool> granted;  ///< at run time, perhaps
  std::set<Delivery> at_run_time;
  std::map<OnBus, core::MediumUse> on_bus;  ///< of what is granted
  std::size_t without_links = 0;            ///< verdicts over a mesh that has no links
  /// Networks of those: where all is granted so far, and where something is refused for a link.
  std::map<std::size_t, bool> misses_links;
  std::set<std::size_t> refused_over;  ///< networks of those over which something is refused
  std::size_t awaits_links = 0;        ///< of them: left to the run time because of that mesh
};

inline Checked checked(const std::string& text) {
  Checked out;
  auto system = description::read_memory(text, "random.xml", {}, description::Users::any);
  if (!system) {
    for (const auto& problem : system.error()) ADD_FAILURE() << description::to_string(problem);
    ADD_FAILURE() << text;
    return out;
  }
  out.system = std::move(*system);
  out.system.sort_bindings();
  std::set<std::size_t> used;
  out.inspection = core::inspect(
      out.system, {},
      [&](std::size_t channel, const core::Decision& decision, std::span<const core::Finding>) {
        if (!used.insert(channel).second) return;
        for (const core::Verdict& v : decision.verdicts) {
          out.granted[{channel, v.publisher, v.to}] = v.outcome != Outcome::unfit;
          if (v.outcome == Outcome::run_time) out.at_run_time.insert({channel, v.publisher, v.to});
          for (const core::MediumUse& use : v.media)
            if (v.granted && use.key != 0) out.on_bus[{use.network, use.key}] = use;
          for (const core::Place hop : v.route) {
            if (!has_no_links(out.system, hop)) continue;
            ++out.without_links;
            out.misses_links[hop.index] |=
                v.obstacle == core::Obstacle::no_path && v.obstacle_at == hop;
            if (v.outcome == Outcome::unfit) out.refused_over.insert(hop.index);
          }
          for (const core::Row& row : v.rows)
            out.awaits_links += row.against == core::Against::medium_time &&
                                        row.comparison.outcome == Outcome::run_time &&
                                        has_no_links(out.system, row.place)
                                    ? 1
                                    : 0;
        }
      });
  return out;
}

class Levels : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    for (std::uint64_t seed = 1; seed <= kSystems; ++seed) {
      texts_.push_back(random_system(seed));
      all_.push_back(checked(texts_.back()));
    }
  }
  static void TearDownTestSuite() {
    texts_.clear();
    all_.clear();
  }
  static inline std::vector<std::string> texts_;
  static inline std::vector<Checked> all_;
};

}  // namespace mlcca::testing
