// SPDX-License-Identifier: BSD-2-Clause
// What mlccad asks for, done at one member of the store after the other. It gives no meaning to a
// key or a value.
#pragma once
#include <systemd/sd-event.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/problem.hpp"
#include "base/result.hpp"
#include "cluster/channel.hpp"
#include "cluster/endpoints.hpp"
#include "cluster/etcd.hpp"
#include "cluster/follower.hpp"
#include "cluster/outbox.hpp"
#include "cluster/settings.hpp"
#include "daemon/cluster/wire.hpp"
#include "daemon/net/sources/timer.hpp"

namespace mlcca::cluster {

class Bridge {
 public:
  struct Outside {
    std::function<Result<std::unique_ptr<Channel>>(const std::string& endpoint)> open;
    std::function<void(const std::string&)> log;
  };
  Bridge(sd_event* loop, const Settings& settings, Outside outside);

  [[nodiscard]] Result<void> start();
  /// Called when there is something in the outbox.
  void on_output(std::function<void()> call) { wrote_ = std::move(call); }

  /// A message of mlccad. Nothing is asked of the store before it has said hello.
  void take(wire::ToStore message);
  /// mlccad has gone: nothing more is asked of the store.
  void end_session();
  [[nodiscard]] Outbox& outbox() { return outbox_; }
  /// Some of the outbox was sent.
  void sent() { follower_.go_on(); }
  /// As many transactions are under way as may be.
  [[nodiscard]] bool is_busy() const { return under_way_.size() >= kMostUnderWay; }

 private:
  static constexpr std::size_t kMostUnderWay = 64;

  struct UnderWay {
    std::vector<std::string> gets;
    std::optional<etcd::TxnAnswer> answer;
    std::unique_ptr<Call> call;
  };

  void connect();
  void ask_status();
  void take_status(const End& end, std::uint64_t asked);
  void take_trouble(Follower::Trouble trouble, const std::string& why);
  void follow();
  void run(const core::cluster::Txn& txn);
  void end_txn(std::uint64_t id, const End& end);
  void note_failure(const std::string& why);
  void answer(const core::cluster::TxnResult& result);
  void drop(const std::string& why);
  void put_state();

  sd_event* loop_;
  Settings settings_;
  Outside outside_;
  std::function<void()> wrote_;
  Endpoints endpoints_;
  Outbox outbox_;
  std::unique_ptr<Channel> channel_;
  std::unique_ptr<Channel> retired_;  ///< it may be calling us
  Follower follower_;
  std::map<std::uint64_t, UnderWay> under_way_;  ///< by the number of the transaction
  std::unique_ptr<Call> status_call_;
  std::optional<etcd::Status> fresh_;   ///< what is answered now
  std::optional<etcd::Status> status_;  ///< the latest that was well
  bool session_ = false;
  bool confirmed_ = false;  ///< this member knows a leader
  unsigned failures_ = 0;   ///< of transactions, one after the other
  std::uint64_t latency_ = 0;
  std::string refused_;  ///< why nothing can be followed
  std::string problem_;  ///< why there is no member to ask
  Problem logged_;
  std::uint64_t pause_;  ///< µs before what is followed is asked for again
  net::Timer poll_;
  net::Timer reconnect_;
  net::Timer refollow_;
};

}  // namespace mlcca::cluster
