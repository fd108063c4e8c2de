// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <string>
#include <vector>

#include "core/cluster/member.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/shared_networks.hpp"

namespace mlcca {

/// Without its former journal, this gateway would give numbers again that the store still has for
/// other admissions of it, and the store would count both as the same traffic. Where it has given
/// one again before it knew the store, nothing more is reserved until the former one has left.
class FormerNumbers {
 public:
  void forget() { numbers_.clear(); }
  /// To be called when the store is known: looks for such numbers, and lets `recorder` pass over
  /// all that the store has.
  void find(const core::cluster::Member& member, Recorder& recorder);
  /// Why nothing can be reserved now; empty if it can.
  [[nodiscard]] std::string in_the_way(const core::cluster::Member& member);

 private:
  /// Of a process before, in the store, with numbers of other admissions of now.
  std::vector<SharedNetworks::Number> numbers_;
};

}  // namespace mlcca
