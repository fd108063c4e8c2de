// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/following.hpp"

namespace mlcca::core::cluster {

void Following::note_loaded(const Digest& loaded, const Digest& file) {
  if (wanted != loaded) return;
  rolled = loaded;
  replaced = file;
  wanted.reset();
}

/// What came by a rollout is replaced by the next one; so is the file that a rollout has replaced,
/// where the text of the rollout is lost. What the operator has loaded is replaced by a description
/// that comes into force later, not by one that was in force before.
void Following::on(const Switch& event, const Digest& loaded) {
  if (event.digest == loaded) {
    if (event.open) in_force = event.digest;
    wanted.reset();
    return;
  }
  const bool by_rollout = loaded == rolled || loaded == replaced;
  const bool is_new = event.digest != in_force;
  if (by_rollout || (is_new && (event.digest == voted || loaded == in_force)))
    wanted = event.digest;
}

}  // namespace mlcca::core::cluster
