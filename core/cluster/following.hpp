// SPDX-License-Identifier: BSD-2-Clause
// Which description a gateway loads, by what rollouts have put in force in its cluster and by the
// file of the operator. See docs/explanation/cluster.md, "One description".
#pragma once
#include <optional>

#include "core/cluster/types.hpp"

namespace mlcca::core::cluster {

/// What a gateway remembers of rollouts over a restart, and the description that it is to load. A
/// digest of zeros is that of no description.
struct Following {
  Digest rolled = {};    ///< what a rollout has put in force here
  Digest replaced = {};  ///< digest of the file that it replaces
  Digest in_force = {};  ///< the latest one of the cluster that was in force here as well
  Digest voted = {};     ///< the latest one that this gateway has agreed to
  std::optional<Digest> wanted = std::nullopt;  ///< is to be loaded here

  /// Takes what is in force in the cluster. `loaded`: what is loaded here.
  void on(const Switch& event, const Digest& loaded);
  /// The kernel has taken `loaded`, whoever has loaded it. `file`: digest of the file.
  void note_loaded(const Digest& loaded, const Digest& file);
  /// Whether a start loads `rolled` instead of the file with that digest. A file that has changed
  /// since the rollout is what the operator wants.
  [[nodiscard]] bool replaces(const Digest& file) const {
    return file == replaced && file != rolled;
  }
};

}  // namespace mlcca::core::cluster
