// SPDX-License-Identifier: BSD-2-Clause
// What the relay asks a daemon, and when.
#include "relay/grants.hpp"

#include <gtest/gtest.h>
#include <poll.h>

#include <atomic>
#include <string>
#include <variant>
#include <vector>

#include "tests/control/server.hpp"

namespace mlcca::relay {
namespace {

constexpr std::uint32_t kUser = 990;
constexpr int kPatience = 60'000;  // ms, for what takes none

control::Transfers transfers(std::size_t count) {
  control::Transfers out;
  for (std::size_t i = 0; i < count; ++i) {
    out.transfers.emplace_back();
    out.transfers.back().subject = i + 1;
  }
  return out;
}
control::Reply event(const std::string& kind, std::uint64_t subject) {
  control::Event out;
  out.kind = kind;
  out.subject = subject;
  return {0, std::move(out)};
}

struct Seen {
  std::vector<std::size_t> all;
  std::vector<std::pair<std::uint64_t, std::size_t>> of_subject;
  std::vector<std::string> log;
};

Grants::Handlers handlers(Seen& seen) {
  return {
      .all = [&](const auto& some) { seen.all.push_back(some.size()); },
      .of_subject = [&](std::uint64_t subject,
                        const auto& some) { seen.of_subject.emplace_back(subject, some.size()); },
      .log = [&](const std::string& line) { seen.log.push_back(line); }};
}

/// Turns until it is so.
template <class Condition>
void turn_until(Grants& grants, Condition condition) {
  while (!condition()) {
    pollfd waits{.fd = grants.fd(), .events = POLLIN, .revents = 0};
    ASSERT_GT(::poll(&waits, 1, kPatience), 0) << "nothing would wake it";
    grants.turn();
  }
}

TEST(GrantsTest, AllIsAskedForAtOnceAndWhatChangesBySubject) {
  std::atomic<int> asked = 0;
  test::Server server([&](const control::Request& request) {
    test::Server::Answer answer;
    if (std::holds_alternative<control::MonitorRequest>(request.body)) {
      answer.replies = {{0, control::Done{}}};
    } else if (std::get<control::TransfersRequest>(request.body).channel.empty()) {
      ++asked;
      answer.replies = {{0, transfers(2), true},
                        {0, transfers(1)},
                        event("withdrawn", 7),
                        event("missing", 8),
                        event("withdrawn", 7)};
    } else {
      answer.replies = {{0, transfers(0)}};
    }
    return answer;
  });
  Seen seen;
  Grants grants(server.path(), kUser, handlers(seen));
  turn_until(grants, [&] { return !seen.of_subject.empty(); });
  EXPECT_EQ(seen.all, std::vector<std::size_t>{3}) << "slices are put together";
  EXPECT_EQ(seen.of_subject, (std::vector<std::pair<std::uint64_t, std::size_t>>{{7, 0}}));
  const auto requests = server.requests();
  ASSERT_EQ(requests.size(), 3U);
  EXPECT_EQ(std::get<control::TransfersRequest>(requests[1].body).user, kUser);
  EXPECT_EQ(std::get<control::TransfersRequest>(requests[2].body).channel, "0x0000000000000007");
  grants.ask_all();
  turn_until(grants, [&] { return seen.all.size() == 2; });
  EXPECT_EQ(asked, 2);
}

TEST(GrantsTest, ADaemonThatGoesIsAskedAgainWhenItComesBack) {
  std::atomic<int> connections = 0;
  test::Server server([&](const control::Request& request) {
    test::Server::Answer answer;
    if (std::holds_alternative<control::MonitorRequest>(request.body)) {
      ++connections;
      return answer;
    }
    answer.replies = {{0, transfers(1)}};
    answer.hang_up = connections == 1;
    return answer;
  });
  Seen seen;
  Grants grants(server.path(), kUser, handlers(seen));
  turn_until(grants, [&] { return seen.all.size() == 2; });
  EXPECT_EQ(seen.log,
            (std::vector<std::string>{
                "mlccad closed the connection: what is carried stays, and its gates decide",
                "mlccad answers again"}));
}

TEST(GrantsTest, AReloadAsksForAllAgain) {
  std::atomic<int> asked = 0;
  test::Server server([&](const control::Request& request) {
    test::Server::Answer answer;
    if (!std::holds_alternative<control::TransfersRequest>(request.body)) return answer;
    answer.replies = {{0, transfers(1)}};
    if (++asked == 1) answer.replies.push_back(event("reload", 0));
    return answer;
  });
  Seen seen;
  Grants grants(server.path(), kUser, handlers(seen));
  turn_until(grants, [&] { return seen.all.size() == 2; });
  EXPECT_TRUE(seen.of_subject.empty());
}

}  // namespace
}  // namespace mlcca::relay
