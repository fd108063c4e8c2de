// SPDX-License-Identifier: BSD-2-Clause
// The connection of a program to mlccad, which is made again whenever it is lost.
#pragma once
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "client/answers.hpp"
#include "client/data.hpp"
#include "client/part.hpp"
#include "control/buffer.hpp"
#include "control/messages.hpp"
#include "mlcca/client/client.hpp"

namespace mlcca::client {

/// Implements Client: announces the channels, keeps their answers up to date and calls the
/// handlers. Only take_up() and run() wait. One epoll instance contains all descriptors of the
/// client, so that an application needs to poll a single one.
class Client::Connection {
 public:
  using Clock = std::chrono::steady_clock;
  using PartOf = std::shared_ptr<Channel::Part>;

  explicit Connection(Options options);

  [[nodiscard]] int fd() const { return epoll_.get(); }
  [[nodiscard]] bool is_connected() const { return static_cast<bool>(socket_); }
  /// Has the channel announced whenever a connection is made, until the channel is destroyed.
  void add(const PartOf& part);
  /// Announces the channel and waits for the answer, for Options::patience at most; the channel's
  /// answer has the result.
  void take_up(const PartOf& part);
  /// Receives, sends and connects as far as that is possible without waiting.
  void turn();
  /// Waits until there is work to do, for `time` at most (negative: without limit), does it, and
  /// calls the handlers. Throws what a handler throws; the rest is kept for the next call.
  void run(std::chrono::milliseconds time);
  [[nodiscard]] Data& data() { return data_; }

 private:
  /// A request that has not been answered completely. Its channel may have been destroyed.
  struct PendingRequest {
    std::weak_ptr<Channel::Part> part;
    std::optional<control::Reply> whole{};  ///< the slices of the reply received so far, joined
    /// Channels in these slices; bounded, since the daemon is not trusted to end.
    std::size_t rows = 0;
  };

  [[nodiscard]] bool is_own(int fd) const {
    return fd == socket_.get() || fd == timer_.get() || fd == supervision_.get() ||
           fd == noticed_.get();
  }
  /// Why a connection is made: only attempts by the timer double the delay before the next one.
  enum class Try : std::uint8_t { planned, asked_for };
  void connect(Try why);
  void lose(const std::string& why, Try after = Try::planned);
  void retry_later(Try after);
  void note_gone(const std::string& why, Clock::time_point since);
  void note_received();
  void supervise();
  [[nodiscard]] bool is_supervised() const { return options_.answers_within.count() > 0; }
  void ask(const PartOf& part);
  void receive();
  void take_replies();
  void flush();
  void watch();
  void on_reply(control::Reply reply);
  void on_event(const control::Event& event);
  void on_event(const PartOf& part, const control::Event& event, Meaning meaning);
  void withdraw(const PartOf& part, const control::Event& event);
  void on_happened(const PartOf& part, const control::Event& event);
  void on_answer(const PartOf& part, const control::Reply& reply);
  void carry(const PartOf& part, const control::Reply& reply);
  /// Announces the channel once more: at once, or after the answer to a pending request.
  void ask_again(const PartOf& part);
  void wake();
  [[nodiscard]] bool has_exceptions();
  void call_exception_handlers();
  void wait_for_daemon(std::chrono::milliseconds time) const;
  /// The channels that still exist.
  std::vector<PartOf> parts();

  Options options_;
  Fd epoll_;
  Fd timer_;  ///< expires when it is time to connect, or to ask again for channels that failed
  Fd supervision_;  ///< timer: it is time to ask whether the daemon answers, or to give it up
  Fd noticed_;      ///< eventfd, readable while exceptions wait for handlers
  Fd socket_;
  /// Delay before the next attempt to connect.
  std::chrono::milliseconds retry_;
  /// Received bytes that are not decoded yet.
  control::Buffer in_;
  /// Encoded requests that are not sent yet.
  std::string out_;
  std::uint64_t last_id_ = 0;
  std::uint64_t ping_ = 0;  ///< id of the pending ping; 0: none
  /// When the latest octets came from the daemon, and when the ping was sent.
  Clock::time_point received_;
  Clock::time_point pinged_;
  bool stops_ = false;       ///< it has said on this connection that it stops
  bool hangs_ = false;       ///< it has not answered the ping in time
  bool knows_pings_ = true;  ///< false: an older daemon, which closes the connection instead
  /// Pending requests by their ids.
  std::map<std::uint64_t, PendingRequest> asked_;
  std::vector<std::weak_ptr<Channel::Part>> parts_;
  Data data_{epoll_};
};

}  // namespace mlcca::client
