// SPDX-License-Identifier: BSD-2-Clause
// What the daemon says is to be carried: asked for when the relay starts, when the daemon comes
// back, and when its events say that it may be otherwise. While the daemon is gone, what it said
// last stays.
#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "control/buffer.hpp"
#include "control/messages.hpp"

namespace mlcca::relay {

class Grants {
 public:
  using Transfers = std::vector<control::Transfer>;
  struct Handlers {
    std::function<void(const Transfers&)> all;
    std::function<void(std::uint64_t subject, const Transfers&)> of_subject;
    std::function<void(const std::string&)> log;
  };

  /// `user`: whose transfers are asked for.
  Grants(std::string socket, std::uint32_t user, Handlers handlers);

  /// Can be read when turn() has something to do: an epoll instance.
  [[nodiscard]] int fd() const { return epoll_.get(); }
  /// Receives, sends, connects: what can be done without waiting.
  void turn();
  [[nodiscard]] bool is_connected() const { return static_cast<bool>(socket_); }
  /// The daemon has answered once what there is to carry.
  [[nodiscard]] bool has_answer() const { return has_answer_; }
  /// Tells the daemon, if it is there and has answered. Its reply says nothing that matters here.
  void report(control::DelayRequest delay);
  /// All is asked for once more, soon: an interface has gone or come.
  void ask_all();

 private:
  void connect();
  void lose(const std::string& why);
  void ask_next();
  void send(control::Request request);
  void flush();
  void receive();
  void on_reply(control::Reply reply);
  void on_event(const control::Event& event);
  void set_timer(std::chrono::milliseconds time);

  std::string path_;
  std::uint32_t user_;
  Handlers handlers_;
  Fd epoll_;
  Fd timer_;  ///< when to connect again, or to ask
  Fd socket_;
  std::chrono::milliseconds retry_;
  control::Buffer in_;
  std::string out_;
  std::uint64_t last_id_ = 0;
  std::uint64_t asked_ = 0;                  ///< the request that is under way, 0: none
  std::optional<std::uint64_t> of_subject_;  ///< of it; none: of all
  std::optional<control::Reply> whole_;      ///< what has come of it
  bool all_due_ = false;
  std::set<std::uint64_t> due_;  ///< subjects
  bool has_answer_ = false;
  bool reported_gone_ = false;
};

}  // namespace mlcca::relay
