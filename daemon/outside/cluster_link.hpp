// SPDX-License-Identifier: BSD-2-Clause
// An interface for the connection to the store that gateways share: mlcca-cluster at the other end
// of a socket, or a fake.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "core/cluster/store.hpp"

namespace mlcca {

/// The begin of a snapshot of the followed keys. What was known before is replaced at its end.
struct ClusterSnapshot {
  std::int64_t revision = 0;
};
/// The end of the snapshot. The changes after it follow, one batch for each revision.
struct ClusterSynced {
  std::int64_t revision = 0;
};

using ClusterMessage = std::variant<core::cluster::StoreState, ClusterSnapshot,
                                    core::cluster::Batch, ClusterSynced, core::cluster::TxnResult>;

class ClusterLink {
 public:
  ClusterLink() = default;
  ClusterLink(const ClusterLink&) = delete;
  ClusterLink& operator=(const ClusterLink&) = delete;
  ClusterLink(ClusterLink&&) = delete;
  ClusterLink& operator=(ClusterLink&&) = delete;
  virtual ~ClusterLink() = default;

  /// Sets the cluster and gateway that mlcca-cluster learns with the next connection.
  virtual void introduce(std::string cluster, std::string gateway) = 0;
  /// Sends a transaction. It is answered by one TxnResult, never during this call.
  virtual void send(const core::cluster::Txn& txn) = 0;
  /// Follows the keys with these prefixes from now on. A snapshot comes first.
  virtual void follow(std::vector<std::string> prefixes) = 0;
  virtual void on_message(std::function<void(ClusterMessage)> call) = 0;
  /// For the time before the loop runs: waits at most `ns` nanoseconds until something happens.
  virtual void wait(std::uint64_t ns) = 0;
};

}  // namespace mlcca
