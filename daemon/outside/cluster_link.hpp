// SPDX-License-Identifier: BSD-2-Clause
// The way to the store that gateways share: mlcca-cluster behind a socket, or a fake.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "core/cluster/store.hpp"

namespace mlcca {

/// A snapshot of what is followed begins: what was known before is replaced when it has ended.
struct ClusterSnapshot {
  std::int64_t revision = 0;
};
/// It has ended. What follows are the changes after it, each revision as one batch.
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

  /// As whom mlcca-cluster gets to know this gateway, with the next connection.
  virtual void introduce(std::string cluster, std::string gateway) = 0;
  /// Each is answered by one TxnResult, never within this call.
  virtual void send(const core::cluster::Txn& txn) = 0;
  /// Keys with one of these prefixes, from now on: a snapshot follows.
  virtual void follow(std::vector<std::string> prefixes) = 0;
  virtual void on_message(std::function<void(ClusterMessage)> call) = 0;
  /// Before the loop runs: waits for something to happen, for so many ns at most.
  virtual void wait(std::uint64_t ns) = 0;
};

}  // namespace mlcca
