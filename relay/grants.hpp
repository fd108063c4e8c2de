// SPDX-License-Identifier: BSD-2-Clause
// What the daemon says is to be carried: asked for when the relay starts, when the daemon comes
// back, and when its events say that it may be otherwise. While the daemon is gone, what it said
// last stays.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "control/messages.hpp"
#include "relay/daemon_link.hpp"

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

  /// See DaemonLink.
  [[nodiscard]] int fd() const { return link_.fd(); }
  void turn() { link_.turn(); }
  [[nodiscard]] bool is_connected() const { return link_.is_connected(); }
  /// The daemon has answered once what there is to carry.
  [[nodiscard]] bool has_answer() const { return has_answer_; }
  /// Tells the daemon, if it is there and has answered. Its reply says nothing that matters here.
  void report(control::DelayRequest delay);
  /// All is asked for once more, soon: an interface has gone or come.
  void ask_all();

 private:
  void ask_next();
  void on_reply(const control::Reply& reply);
  void on_event(const control::Event& event);

  std::uint32_t user_;
  Handlers handlers_;
  std::uint64_t asked_ = 0;                  ///< the request that is under way, 0: none
  std::optional<std::uint64_t> of_subject_;  ///< of it; none: of all
  bool all_due_ = false;
  std::set<std::uint64_t> due_;  ///< subjects
  bool has_answer_ = false;
  DaemonLink link_;
};

}  // namespace mlcca::relay
