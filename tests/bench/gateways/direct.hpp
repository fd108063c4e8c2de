// SPDX-License-Identifier: BSD-2-Clause
// The store by libcurl alone, one call after the other.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "cluster/channel.hpp"
#include "cluster/etcd.hpp"
#include "cluster/grpc.hpp"
#include "cluster/http.hpp"
#include "cluster/settings.hpp"
#include "tests/bench/measure.hpp"
#include "tests/cluster/gateway.hpp"
#include "tests/cluster/processes.hpp"

namespace mlcca::bench {

/// Settings of a user whose certificate is in the folder.
inline cluster::Settings settings_of(const test::WorkFolder& folder, const std::string& user) {
  cluster::Settings settings;
  settings.ca = folder / "ca.pem";
  settings.certificate = folder / (user + ".pem");
  settings.key = folder / (user + ".key");
  settings.timeout_ms = 60'000;
  return settings;
}

class Direct {
 public:
  Direct(const test::Loop& loop, const cluster::Settings& settings, const std::string& endpoint)
      : loop_(loop) {
    auto channel = cluster::open_http(loop.get(), settings, endpoint);
    require(channel.has_value(), "a channel to the store");
    channel_ = std::move(*channel);
  }
  /// Its revision.
  std::int64_t run(const core::cluster::Txn& txn) {
    const std::string answer = call(cluster::etcd::kTxn, cluster::etcd::txn_request(txn));
    const auto read = cluster::etcd::read_txn(answer, txn.else_get);
    require(read && read->succeeded, "a bare transaction failed");
    return read->header.revision;
  }
  cluster::etcd::Status status() {
    const auto read = cluster::etcd::read_status(call(cluster::etcd::kStatus, {}));
    require(read.has_value(), "the status of the store");
    return *read;
  }

 private:
  std::string call(std::string_view method, std::string message) {
    bool done = false;
    std::string answer;
    const auto call =
        channel_->start({.method = method,
                         .message = std::move(message),
                         .timeout_ms = 60'000,
                         .on_answer = [&](std::string octets) { answer = std::move(octets); },
                         .on_end = [&](const cluster::End&) { done = true; }});
    loop_.until([&] { return done; }, std::chrono::minutes(1));
    return answer;
  }

  const test::Loop& loop_;
  std::unique_ptr<cluster::Channel> channel_;
};

}  // namespace mlcca::bench
