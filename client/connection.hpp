// SPDX-License-Identifier: BSD-2-Clause
// The connection of a program to mlccad: made again whenever it is lost, never waits by itself.
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

class Client::Connection {
 public:
  using Clock = std::chrono::steady_clock;
  using PartOf = std::shared_ptr<Channel::Part>;

  explicit Connection(Options options);

  [[nodiscard]] int fd() const { return epoll_.get(); }
  [[nodiscard]] bool is_connected() const { return static_cast<bool>(socket_); }
  /// From now on it is announced whenever there is a daemon.
  void add(const PartOf& part);
  /// Asks for it, and waits for the answer at most as long as the options say.
  void take_up(const PartOf& part);
  /// Receives, sends, connects: what can be done without waiting.
  void turn();
  /// Waits until there is something to do, at most so long, does it, and calls handlers for events
  /// and for what has happened.
  void run(std::chrono::milliseconds time);
  [[nodiscard]] Data& data() { return data_; }

 private:
  /// A request that is not answered yet; of a channel that may be gone.
  struct Asked {
    std::weak_ptr<Channel::Part> part;
    std::optional<control::Reply> whole{};  ///< what has come of it
    std::size_t rows = 0;
  };

  /// Whether a failure makes the next try come later.
  enum class Try : std::uint8_t { planned, asked_for };
  void connect(Try why);
  void lose(const std::string& why, Try after = Try::planned);
  void retry_later(Try after);
  void ask(const PartOf& part);
  void receive();
  void take_replies();
  void flush();
  void watch();
  void on_reply(control::Reply reply);
  void on_event(const control::Event& event);
  void on_event(const PartOf& part, const control::Event& event, Meaning meaning);
  void on_happened(const PartOf& part, const control::Event& event);
  void on_answer(const PartOf& part, const control::Reply& reply);
  void carry(const PartOf& part, const control::Reply& reply);
  /// What is decided is asked for once more: at once, or when the answer under way is there.
  void ask_again(const PartOf& part);
  void wake();
  [[nodiscard]] bool has_exceptions();
  void call_exception_handlers();
  void wait_for_daemon(std::chrono::milliseconds time) const;
  /// Those that still exist.
  std::vector<PartOf> parts();

  Options options_;
  Fd epoll_;
  Fd timer_;    ///< when to connect again
  Fd noticed_;  ///< eventfd that can be read while there is something for handlers
  Fd socket_;
  std::chrono::milliseconds retry_;
  control::Buffer in_;
  std::string out_;
  std::uint64_t last_id_ = 0;
  std::map<std::uint64_t, Asked> asked_;
  std::vector<std::weak_ptr<Channel::Part>> parts_;
  Data data_{epoll_};
};

}  // namespace mlcca::client
