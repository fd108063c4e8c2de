// SPDX-License-Identifier: BSD-2-Clause
// A daemon that answers a program what a test wants.
#pragma once
#include <chrono>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "mlcca/client/client.hpp"
#include "tests/control/server.hpp"

namespace mlcca::client {

using std::chrono::milliseconds;
using test::Server;
using Replies = std::vector<control::Reply>;

inline constexpr std::uint64_t kSubject = 0xa4efeccc3210b497;
inline constexpr milliseconds kLong(60'000);  // for what takes no time, on a machine that is busy

inline control::Channel delivery(const std::string& to, bool granted, std::uint32_t set = 0) {
  control::Channel out;
  out.subject = kSubject;
  out.name = "stop";
  out.publisher = "lever";
  out.from = "bridge";
  out.to = to;
  out.granted = granted;
  out.set = set;
  out.reason = granted ? "1 to spare" : "Omission 2 required, bridge provides 5 (3 too many)";
  out.rows = {{.where = "bridge",
               .attribute = "Omission",
               .unit = "events",
               .required = 2,
               .provided_known = true,
               .provided = granted ? 1U : 5U,
               .dynamic = false,
               .outcome = granted ? control::Outcome::fit : control::Outcome::unfit,
               .margin = granted ? "1 to spare" : "3 too many"}};
  return out;
}
inline control::Reply channels(std::vector<control::Channel> all) {
  return {0, control::Channels{std::move(all), 0}};
}
inline control::Reply event(const std::string& kind, std::uint64_t subject = kSubject) {
  control::Event out;
  out.kind = kind;
  out.subject = subject;
  out.channel = subject == 0 ? "" : "stop";
  out.message = "what is " + kind;
  return {0, std::move(out)};
}

/// Answers each request with the next ones of a list, and with the last ones again.
class Script {
 public:
  explicit Script(std::deque<Server::Answer> answers) : answers_(std::move(answers)) {}
  Server::Answer next() {
    const std::scoped_lock hold(lock_);
    Server::Answer answer = answers_.front();
    if (answers_.size() > 1) answers_.pop_front();
    return answer;
  }

 private:
  std::mutex lock_;
  std::deque<Server::Answer> answers_;
};

class Scene {
 public:
  explicit Scene(std::deque<Server::Answer> answers)
      : script_(std::move(answers)),
        server_([this](const control::Request&) { return script_.next(); }) {}

  [[nodiscard]] Options options() const {
    return {.socket = server_.path(),
            .patience = kLong,
            .first_retry = milliseconds(1),
            .longest_retry = milliseconds(1)};
  }
  std::vector<control::Request> requests() { return server_.requests(); }
  void hang(bool hangs) { server_.hang(hangs); }

 private:
  Script script_;
  Server server_;
};

/// What comes to the handler of a channel, until there are so many of them.
inline std::vector<Exception> exceptions(Client& client, Channel& channel, std::size_t count) {
  std::vector<Exception> all;
  channel.on_exception([&all](const Exception& e) { all.push_back(e); });
  while (all.size() < count) client.wait(kLong);
  channel.on_exception(nullptr);
  return all;
}

inline std::vector<std::string> causes(const std::vector<Exception>& all) {
  std::vector<std::string> out;
  for (const Exception& e : all) out.emplace_back(name_of(e.cause));
  return out;
}

}  // namespace mlcca::client
