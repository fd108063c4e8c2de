// SPDX-License-Identifier: BSD-2-Clause
// The server over a real socket and loop, with answers that a test makes up.
#include "daemon/serve/server.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "control/buffer.hpp"
#include "control/codec.hpp"
#include "control/slices.hpp"
#include "tests/daemon/serve/server_bench.hpp"

namespace mlcca::serve {
namespace {

TEST_F(ServerTest, WhatIsEncodedIsPassedOnUnderTheIdOfItsRequest) {
  answer_ = [](const Request& request, const Peer&) {
    Answer answer{Reply{request.id, {}}};
    answer.slices = [next = 0]() mutable -> std::optional<Slice> {
      const bool more = ++next < 3;
      const Reply slice{0, control::Done{std::to_string(next)}, more};
      return Slice{{}, more, control::encode_body(slice)};
    };
    return answer;
  };
  const Fd socket = client();
  control::Buffer buffer;
  ask(socket, 300);
  ask(socket, 301);
  const auto all = replies(socket, buffer);
  ASSERT_EQ(all.size(), 6U);
  for (std::size_t i = 0; i < all.size(); ++i)
    EXPECT_EQ(all[i], (Reply{300 + i / 3, control::Done{std::to_string(i % 3 + 1)}, i % 3 != 2}));
}

TEST_F(ServerTest, SlicesComeInOrderAndTheNextReplyBehindThem) {
  answer_ = [&](const Request& r, const Peer&) { return channels(r.id, 5, 10); };
  const Fd socket = client();
  ask(socket, 1);
  ask(socket, 2);
  control::Buffer buffer;
  const auto all = replies(socket, buffer);
  ASSERT_EQ(all.size(), 10U);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(all[i].id, i / 5 + 1);
    EXPECT_EQ(all[i].more, i % 5 != 4);
    EXPECT_EQ(std::get<control::Channels>(all[i].body).channels.at(0).subject, i % 5);
  }
}

TEST_F(ServerTest, NothingIsMadeForAClientThatDoesNotRead) {
  answer_ = [&](const Request& r, const Peer&) { return channels(r.id, 100'000, 8192); };
  const Fd socket = client();
  const int small = 65536;
  ::setsockopt(socket.get(), SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
  for (std::uint64_t id = 1; id <= 16; ++id) ask(socket, id);
  run();
  const int made = made_;
  EXPECT_GT(made, 16);
  EXPECT_LT(made, 200);  // 256 KiB, and what the kernel takes
  run();
  EXPECT_EQ(made_, made);
}

TEST_F(ServerTest, AClientThatReadsLateGetsEverything) {
  answer_ = [&](const Request& r, const Peer&) { return channels(r.id, 500, 8192); };
  const Fd socket = client();
  ask(socket, 1);
  run();
  control::Buffer buffer;
  EXPECT_EQ(replies(socket, buffer).size(), 500U);
}

TEST_F(ServerTest, AClientOfBeforeGetsOneReplyOfAtMostAMebibyte) {
  int rows = 100;
  answer_ = [&](const Request& r, const Peer&) { return channels(r.id, rows, 10'000); };
  const Fd socket = client();
  control::Buffer buffer;
  ask(socket, 1, false);
  auto all = replies(socket, buffer);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_FALSE(all[0].more);
  ASSERT_EQ(std::get<control::Channels>(all[0].body).channels.size(), 100U);
  rows = 110;
  ask(socket, 2, false);
  all = replies(socket, buffer);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].id, 2U);
  EXPECT_NE(std::get<control::Error>(all[0].body).message.find("slices"), std::string::npos);
}

TEST_F(ServerTest, WhatIsKnownToBeTooLargeIsNotMade) {
  answer_ = [&](const Request& r, const Peer&) {
    Answer answer = channels(r.id, 100'000, 100);
    answer.least_bytes = 100'000UL * 32;
    return answer;
  };
  const Fd socket = client();
  control::Buffer buffer;
  ask(socket, 1, false);
  const auto all = replies(socket, buffer);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<control::Error>(all[0].body));
  EXPECT_EQ(made_, 0);
}

TEST_F(ServerTest, AReplyThatHasToWaitGoesOnWhenItIsResumed) {
  bool there = false;
  std::uint64_t session = 0;
  answer_ = [&](const Request& r, const Peer& peer) {
    session = peer.session;
    Answer answer{Reply{r.id, {}}};
    answer.slices = [&]() -> std::optional<Slice> {
      if (!there) return std::nullopt;
      return Slice{control::Done{"late"}};
    };
    return answer;
  };
  const Fd socket = client();
  control::Buffer buffer;
  ask(socket, 1);
  EXPECT_TRUE(replies(socket, buffer).empty());
  there = true;
  server_->resume(session);
  const auto all = replies(socket, buffer);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(std::get<control::Done>(all[0].body).message, "late");
}

TEST_F(ServerTest, SlicesWaitForTheAnswersBeforeThem) {
  answer_ = [&](const Request& r, const Peer&) {
    if (r.id == 2) return channels(r.id, 2, 10);
    return Answer{Reply{r.id, control::Done{"granted"}}, true};
  };
  const Fd socket = client();
  control::Buffer buffer;
  for (std::uint64_t id = 1; id <= 3; ++id) ask(socket, id);
  EXPECT_TRUE(replies(socket, buffer).empty());
  server_->release({});
  auto all = replies(socket, buffer);
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0].id, 1U);
  EXPECT_EQ(all[1].id, 2U);
  EXPECT_EQ(all[2].id, 2U);
  server_->release({});
  all = replies(socket, buffer);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].id, 3U);
}

TEST_F(ServerTest, WhoFollowsASubjectGetsItsEventsAndThoseThatConcernAll) {
  answer_ = [](const Request& request, const Peer&) {
    Answer answer{Reply{request.id, control::Done{}}};
    if (request.id <= 2) answer.follows = 40 + request.id;
    return answer;
  };
  const Fd follower = client();
  const Fd other = client();
  control::Buffer buffer;
  control::Buffer of_other;
  for (const std::uint64_t id : {1, 2}) ask(follower, id, true, control::AnnounceRequest{});
  ask(other, 3);
  ASSERT_EQ(replies(follower, buffer).size() + replies(other, of_other).size(), 3U);
  const auto publish = [this](std::uint64_t subject, const std::string& kind) {
    server_->publish({.unix_ns = 0, .kind = kind, .subject = subject});
  };
  for (const std::uint64_t subject : {41, 43}) publish(subject, "withdrawn");
  publish(42, "missing");
  for (const char* kind : {"interface", "lapsed", "reload"}) publish(0, kind);
  std::vector<std::string> kinds;
  for (const Reply& reply : replies(follower, buffer))
    kinds.push_back(std::get<control::Event>(reply.body).kind);
  EXPECT_EQ(kinds, (std::vector<std::string>{"withdrawn", "missing", "lapsed", "reload"}));
  EXPECT_TRUE(replies(other, of_other).empty());
}

TEST_F(ServerTest, OneConnectionFollowsAtMost4096Subjects) {
  answer_ = [](const Request& request, const Peer&) {
    Answer answer{Reply{request.id, control::Done{}}};
    answer.follows = request.id;
    return answer;
  };
  const Fd follower = client();
  control::Buffer buffer;
  std::uint64_t refused = 0;
  for (std::uint64_t id = 1; id <= 4098; ++id) {
    ask(follower, id == 4098 ? 1 : id);
    for (const Reply& reply : replies(follower, buffer))
      if (std::holds_alternative<control::Error>(reply.body)) refused = reply.id;
  }
  EXPECT_EQ(refused, 4097U) << "and one that it follows is no further one";
}

TEST_F(ServerTest, WhoHangsUpInTheMiddleIsForgotten) {
  answer_ = [&](const Request& r, const Peer&) { return channels(r.id, 100'000, 8192); };
  {
    const Fd socket = client();
    ask(socket, 1);
    run();
    EXPECT_EQ(server_->sessions(), 1U);
  }
  run();
  EXPECT_EQ(server_->sessions(), 0U);
}

TEST_F(ServerTest, WhatCannotBeReadIsAnsweredAndEndsTheConnection) {
  const Fd socket = client();
  const std::string wrong(64, '\xff');
  ASSERT_GT(::send(socket.get(), wrong.data(), wrong.size(), MSG_NOSIGNAL), 0);
  control::Buffer buffer;
  const auto all = replies(socket, buffer);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<control::Error>(all[0].body));
  EXPECT_EQ(server_->sessions(), 0U);
}

TEST_F(ServerTest, SevenUsersWithAllTheirConnectionsLockNoOtherUserOut) {
  answer_ = [](const Request& r, const Peer&) { return Answer{Reply{r.id, control::Done{}}}; };
  std::vector<Fd> held;
  for (uid_t uid = 100'000; uid < 100'007; ++uid)
    for (int i = 0; i < 32; ++i) held.push_back(client_of(uid));
  EXPECT_TRUE(is_served(client_of(100'007)));
  EXPECT_TRUE(is_served(client_of(0)));
  EXPECT_TRUE(is_served(client_of(100'008, kGroup)));
  const auto in_favour = std::ranges::count_if(held, [this](const Fd& socket) {
    return fate(socket) == "closed in favour of another user: you hold 32 connections";
  });
  EXPECT_GE(in_favour, 1);
}

TEST_F(ServerTest, TwoMembersWithAllTheirConnectionsLockNoOtherUserOut) {
  answer_ = [](const Request& r, const Peer&) { return Answer{Reply{r.id, control::Done{}}}; };
  std::vector<Fd> held;
  for (uid_t uid = 65'001; uid < 65'003; ++uid)
    for (int i = 0; i < 128; ++i) held.push_back(client_of(uid, kGroup));
  for (const uid_t uid : {0U, 65'003U}) EXPECT_TRUE(is_served(client_of(uid)));
  EXPECT_TRUE(is_served(client_of(65'004, kGroup)));
}

TEST_F(ServerTest, WhoAsksForNothingForAMinuteGetsTheReasonAndIsClosed) {
  answer_ = [this](const Request& r, const Peer& peer) {
    if (r.id == 1) return Answer{Reply{r.id, control::Done{"admitted"}}, false, 17};
    if (r.id == 2) {
      Answer waits{Reply{r.id, {}}};
      waits.slices = [] { return std::optional<Slice>{}; };
      return waits;
    }
    return Answer{Reply{r.id, control::Done{std::to_string(peer.session)}}};
  };
  const Fd idle = client();
  const Fd served = client();
  const Fd slow = client();
  const Fd owner = client();
  const Fd waiting = client();
  const Fd listening = client();
  ask(owner, 1);
  ask(waiting, 2);
  ask(served, 3);
  ASSERT_EQ(::send(slow.get(), "\x7f", 1, MSG_NOSIGNAL), 1);
  const std::string monitor = control::encode(Request{4, control::MonitorRequest{}, false});
  ASSERT_GT(::send(listening.get(), monitor.data(), monitor.size(), MSG_NOSIGNAL), 0);
  run();
  server_->sweep(monotonic_ns());
  EXPECT_EQ(server_->sessions(), 6U);
  server_->sweep(monotonic_ns() + Server::kMostIdle + 1);
  EXPECT_EQ(server_->sessions(), 3U);
  for (const Fd* socket : {&idle, &served, &slow})
    EXPECT_EQ(fate(*socket), "closed: no request came for 60 s");
  for (const Fd* socket : {&owner, &waiting, &listening}) EXPECT_EQ(fate(*socket), "");
}

TEST_F(ServerTest, WhoTakesNothingOfAReplyForAMinuteIsClosed) {
  answer_ = [&](const Request& r, const Peer&) { return channels(r.id, 100'000, 8192); };
  const Fd socket = client();
  ask(socket, 1);
  run();
  server_->sweep(monotonic_ns() + Server::kMostIdle + 1);
  EXPECT_EQ(server_->sessions(), 0U);
}

TEST_F(ServerTest, WhatComesWithAConnectionIsAnsweredInTheTurnThatAcceptsIt) {
  answer_ = [](const Request& r, const Peer&) { return Answer{Reply{r.id, control::Done{}}}; };
  const Fd socket = client();
  ask(socket, 1);
  ASSERT_GT(sd_event_run(loop_.get(), 0), 0);
  char byte = 0;
  EXPECT_EQ(::recv(socket.get(), &byte, 1, MSG_DONTWAIT), 1);
}

TEST_F(ServerTest, WhoAsksAndHangsUpIsMadeNothing) {
  answer_ = [&](const Request& r, const Peer&) { return channels(r.id, 5, 10); };
  ::setegid(kNoGroup);
  ::seteuid(100'000);
  Fd socket = client();
  ::seteuid(0);
  ::setegid(0);
  ask(socket, 1);
  socket.reset();
  run();
  EXPECT_EQ(made_, 0);
  EXPECT_EQ(server_->sessions(), 0U);
}

TEST_F(ServerTest, WhatAMemberHasAskedForIsDoneAlsoWhenHeHangsUp) {
  int asked = 0;
  answer_ = [&](const Request& r, const Peer&) {
    ++asked;
    return Answer{Reply{r.id, control::Done{}}};
  };
  Fd socket = client();
  ask(socket, 1);
  socket.reset();
  run();
  EXPECT_EQ(asked, 1);
}

TEST_F(ServerTest, OnlyAUserThatConnectsTooOftenIsRefused) {
  answer_ = [](const Request& r, const Peer&) { return Answer{Reply{r.id, control::Done{}}}; };
  std::string refused;
  for (std::uint64_t i = 0; refused.empty() && i < 100 * Server::kOthersRate.burst; ++i)
    refused = fate(client_of(100'000));
  EXPECT_TRUE(refused.starts_with("you connect too often")) << refused;
  EXPECT_TRUE(is_served(client_of(100'001)));
  EXPECT_TRUE(is_served(client_of(0)));
}

TEST_F(ServerTest, UsersWhoHaveGoneAreForgotten) {
  answer_ = [](const Request& r, const Peer&) { return Answer{Reply{r.id, control::Done{}}}; };
  constexpr std::size_t users = 20;
  for (uid_t uid = 0; uid < users; ++uid) {
    const Fd socket = client_of(100'000 + uid);
    ask(socket, 1);
    run();
  }
  run();
  EXPECT_EQ(server_->users(), users);
  server_->sweep(monotonic_ns() + Server::kMostIdle);
  EXPECT_EQ(server_->users(), 0U);
}

TEST_F(ServerTest, WithoutDescriptorsTheLoopRestsAndAcceptsOnceThereAreSome) {
  answer_ = [](const Request& r, const Peer&) { return Answer{Reply{r.id, control::Done{}}}; };
  Fd first = client();
  run();
  const Fd second = client();
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit none{0, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  int turns = 0;
  while (turns < kManyTurns && sd_event_run(loop_.get(), 0) > 0) ++turns;
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_LT(turns, kManyTurns) << "the loop turns without end";
  first.reset();
  EXPECT_TRUE(is_served(second));
}

TEST_F(ServerTest, ItIsKnownWhoHasHungUpBeforeTheLoopNoticesIt) {
  std::uint64_t session = 0;
  answer_ = [&](const Request& r, const Peer& peer) {
    session = peer.session;
    return Answer{Reply{r.id, control::Done{}}};
  };
  Fd socket = client();
  ask(socket, 1);
  run();
  EXPECT_FALSE(server_->is_gone(session));
  socket.reset();
  EXPECT_TRUE(server_->is_gone(session));
  EXPECT_TRUE(server_->is_gone(session + 1));
}

}  // namespace
}  // namespace mlcca::serve
