// SPDX-License-Identifier: BSD-2-Clause
// The connection of mlccad to mlcca-cluster: a socket whose other end may disappear at any time.
#pragma once
#include <systemd/sd-event.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "base/loop_timer.hpp"
#include "base/result.hpp"
#include "daemon/cluster/wire.hpp"
#include "daemon/outside/cluster_link.hpp"

namespace mlcca::cluster {

/// Each transaction gets one answer, whatever happens at the other end: `unavailable` if it was
/// never sent, `unsure` if it may have been carried out. A connection that ends, sends nothing for
/// 15 s or sends what is not understood is reported as an unreachable StoreState. The next
/// connection is tried a second later, and after each further failure twice as late, up to 32 s.
class SocketLink final : public ClusterLink {
 public:
  struct Options {
    std::string socket = "/run/mlcca/cluster";
    wire::Hello hello;
    std::uint64_t timeout = 15'000'000'000;  ///< ns without a message; then it counts as hanging
    std::uint64_t pause = 1'000'000;         ///< µs before another connection
  };
  SocketLink(sd_event* loop, Options options);

  [[nodiscard]] Result<void> start();

  void introduce(std::string cluster, std::string gateway) override;
  void send(const core::cluster::Txn& txn) override;
  void follow(std::vector<std::string> prefixes) override;
  void on_message(std::function<void(ClusterMessage)> call) override;
  void wait(std::uint64_t ns) override;

 private:
  struct Queued {
    wire::Message message;
    bool of_txn = false;
    std::uint64_t id = 0;  ///< of the transaction
  };
  struct UnderWay {
    std::uint64_t until = 0;  ///< ns: after that it is answered here
    bool sent = false;        ///< a part of it was sent
  };

  static int on_io(sd_event_source*, int, std::uint32_t events, void* self) noexcept;
  void poll();
  void begin();
  void push(Queued queued);
  void send_queued();
  void receive();
  void take(std::size_t size);
  void handle(ClusterMessage message);
  void give_credit(std::size_t entries);
  void answer(std::uint64_t id, core::cluster::Outcome outcome, const std::string& why);
  void answer_late();
  void end(const std::string& why);
  void deliver();

  sd_event* loop_;
  Options options_;
  std::function<void(ClusterMessage)> call_;
  std::vector<std::string> prefixes_;
  Fd socket_;
  EventSource io_;
  LoopTimer timer_;
  LoopTimer deliveries_;
  std::deque<Queued> queue_;
  std::size_t queued_bytes_ = 0;
  std::map<std::uint64_t, UnderWay> under_way_;
  std::deque<ClusterMessage> due_;  ///< messages of this object, delivered in the next turn
  wire::ReaderOfStore reader_;
  std::array<char, wire::kMaxMessage> buffer_{};
  std::size_t handled_ = 0;  ///< entries handled in this turn
  std::size_t owed_ = 0;     ///< credit for entries that is to be given
  std::uint64_t begun_ = 0;  ///< ns
  std::uint64_t received_ = 0;
  std::uint64_t pause_;  ///< µs before the next connection
};

}  // namespace mlcca::cluster
