// SPDX-License-Identifier: BSD-2-Clause
// Connects mlccad with the store (etcd) of a cluster. It carries out what mlccad requests at one
// member of the store, and goes to the next member when that fails. It interprets neither keys nor
// values.
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

#include "base/loop_timer.hpp"
#include "base/outage.hpp"
#include "base/result.hpp"
#include "cluster/channel.hpp"
#include "cluster/etcd.hpp"
#include "cluster/follower.hpp"
#include "cluster/outbox.hpp"
#include "cluster/settings.hpp"
#include "cluster/store_members.hpp"
#include "daemon/cluster/wire.hpp"

namespace mlcca::cluster {

/// The session of mlccad with the store: the transactions under way, the feed of changes (Follower)
/// and the state of the connection. It runs in the event loop and never waits.
class Bridge {
 public:
  /// What the bridge needs from outside; a test gives fakes.
  struct Outside {
    std::function<Result<std::unique_ptr<Channel>>(const std::string& endpoint)> open;
    std::function<void(const std::string&)> log;
  };
  Bridge(sd_event* loop, const Settings& settings, Outside outside);

  /// Starts the timers; an error if the event loop refuses one. It connects once mlccad has said
  /// hello.
  [[nodiscard]] Result<void> start();
  /// Sets the function to call whenever there is something in the outbox.
  void on_output(std::function<void()> call) { wrote_ = std::move(call); }

  /// Takes a message from mlccad. Nothing is requested from the store before mlccad has said hello.
  void take(wire::ToStore message);
  /// Ends the session because mlccad has disconnected: nothing more is requested from the store.
  void end_session();
  [[nodiscard]] Outbox& outbox() { return outbox_; }
  /// Must be called when part of the outbox was sent: the feed may go on.
  void sent() { follower_.go_on(); }
  /// Whether as many transactions are under way as are allowed. The caller reads no further message
  /// from mlccad until that has changed.
  [[nodiscard]] bool is_busy() const { return under_way_.size() >= kMostUnderWay; }

 private:
  static constexpr std::size_t kMostUnderWay = 64;

  /// A transaction whose answer has not come: the keys that it reads if a comparison fails, and the
  /// answer once it is there.
  struct UnderWay {
    std::vector<std::string> gets;
    bool followed = false;  ///< the feed reports what it writes
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
  void note_written(std::int64_t revision);
  [[nodiscard]] bool stands_still();
  void answer(const core::cluster::TxnResult& result);
  void drop(const std::string& why);
  void put_state();
  void log_state(const core::cluster::StoreState& state);

  sd_event* loop_;
  Settings settings_;
  Outside outside_;
  std::function<void()> wrote_;
  StoreMembers endpoints_;
  Outbox outbox_;
  std::unique_ptr<Channel> channel_;
  std::unique_ptr<Channel> retired_;  ///< the former channel, kept because this may run inside one
                                      ///< of its calls
  Follower follower_;
  std::map<std::uint64_t, UnderWay> under_way_;  ///< by the number that mlccad gave the transaction
  std::unique_ptr<Call> status_call_;
  std::optional<etcd::Status> fresh_;   ///< the status that is being received
  std::optional<etcd::Status> status_;  ///< the latest status that was received completely
  bool session_ = false;
  bool confirmed_ = false;  ///< the present member has stated that it knows a leader
  unsigned failures_ = 0;   ///< consecutive transactions that have failed
  std::uint64_t latency_ = 0;
  std::int64_t lacking_ = 0;  ///< a revision that the feed has not reported; 0: none is known
  std::uint64_t lacking_since_ = 0;  ///< CLOCK_MONOTONIC ns
  std::string refused_;              ///< why the store refuses to give the feed; empty: it does not
  std::string problem_;              ///< why no member can be asked; empty: one can
  Outage outage_;
  std::uint64_t pause_;  ///< µs until the feed is requested again
  LoopTimer poll_;
  LoopTimer reconnect_;
  LoopTimer refollow_;
};

}  // namespace mlcca::cluster
