// SPDX-License-Identifier: BSD-2-Clause
// What mlccad would see of a store, by mlccad's own end of the socket.
#pragma once
#include <systemd/sd-event.h>

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "daemon/cluster/link.hpp"
#include "tests/cluster/processes.hpp"

namespace mlcca::test {

class Loop {
 public:
  Loop();
  [[nodiscard]] sd_event* get() const { return loop_.get(); }
  /// Runs until it holds; false after a time that is generous for a busy machine.
  bool until(const std::function<bool()>& holds,
             std::chrono::milliseconds patience = std::chrono::seconds(60)) const;

 private:
  std::unique_ptr<sd_event, FreeWith<sd_event_unref>> loop_;
};

class Gateway {
 public:
  Gateway(sd_event* loop, const std::string& socket, std::vector<std::string> prefixes = {});

  void take(ClusterMessage message);

  cluster::SocketLink link;
  core::cluster::StoreState state{};
  std::vector<core::cluster::StoreState> states;
  int snapshots = 0;        ///< begun
  std::int64_t begun = 0;   ///< revision of the latest
  std::int64_t synced = 0;  ///< revision of the latest that was whole; 0: none since it began
  std::int64_t revision = 0;
  std::map<std::string, core::cluster::Entry> entries;
  std::vector<core::cluster::Batch> changes;  ///< after the snapshot
  std::map<std::uint64_t, core::cluster::TxnResult> results;
};

/// A process mlcca-cluster of a user of the store.
class Bridged {
 public:
  Bridged(const WorkFolder& folder, const std::string& user,
          const std::vector<std::string>& endpoints, const std::string& more = {});

  [[nodiscard]] const std::string& socket() const { return socket_; }
  [[nodiscard]] std::string log() const { return text_of_file(log_); }
  Program program;

 private:
  std::string socket_;
  std::string log_;
};

/// Puts a value under each key if there is none of that key yet.
core::cluster::Txn creation(std::uint64_t id, const std::vector<std::string>& keys,
                            const std::string& value = "v");

}  // namespace mlcca::test
