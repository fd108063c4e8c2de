// SPDX-License-Identifier: BSD-2-Clause
// Programs of FAMOUSO at the handler, by real connections: the bytes are those of the reference.
#include "relay/famouso/handler.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "relay/famouso/peer_user.hpp"
#include "tests/control/server.hpp"

namespace mlcca::relay {
namespace {

using namespace std::string_view_literals;
using std::chrono::seconds;
using std::chrono::steady_clock;

constexpr std::uint64_t kDistance = 0x44697374616e6365;
constexpr auto kSubscribe =
    "\x50"
    "Distance"sv;
constexpr auto kAnnounce =
    "\x56"
    "Distance"sv;
constexpr auto kAbc =
    "\x52"
    "Distance\0\0\0\3abc"sv;
constexpr auto kEmpty =
    "\x52"
    "Distance\0\0\0\0"sv;

/// A program on this host.
class Tcp {
 public:
  explicit Tcp(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_port = htons(port);
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket_.get(), reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
  }
  void say(std::string_view text) {
    EXPECT_EQ(::send(socket_.get(), text.data(), text.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(text.size()));
  }
  /// What has come, without waiting.
  const std::string& heard() {
    std::array<char, 4096> octets{};
    for (ssize_t n = 0;
         (n = ::recv(socket_.get(), octets.data(), octets.size(), MSG_DONTWAIT)) >= 0;) {
      if (n == 0) closed_ = true;
      if (n == 0) break;
      heard_.append(octets.data(), static_cast<std::size_t>(n));
    }
    return heard_;
  }
  bool is_closed() {
    heard();
    return closed_;
  }
  void close() { socket_ = {}; }

 private:
  Fd socket_;
  std::string heard_;
  bool closed_ = false;
};

/// A daemon that grants what passes between programs of this user, unless it is told otherwise.
class HandlerTest : public ::testing::Test {
 protected:
  test::Server::Answer answer(const control::Request& request) {
    const auto* announce = std::get_if<control::AnnounceRequest>(&request.body);
    if (announce == nullptr) return {};
    if (hangs_up_.exchange(false)) return {.replies = {}, .hang_up = true};
    control::Channels channels;
    control::Channel& channel = channels.channels.emplace_back();
    channel.subject = kDistance;
    channel.publisher = "sonar";
    channel.granted = granted_;
    channel.reason = granted_ ? "1 to spare" : "3 too many";
    if (granted_) {
      const std::lock_guard lock(mutex_);
      control::Endpoint endpoint;
      if (announce->role == control::Role::subscriber) {
        endpoint.user = ::getuid();
        address_ = announce->local;
        channels.endpoints.push_back(endpoint);
      } else if (!address_.empty()) {
        endpoint.local = address_;
        channels.endpoints.push_back(endpoint);
      }
    }
    test::Server::Answer out{.replies = {{.id = 0, .body = std::move(channels)}}};
    if (happened_) out.replies.push_back({.id = 0, .body = *happened_});
    return out;
  }

  std::unique_ptr<EventChannelHandler> open(std::optional<std::set<uid_t>> users = {}) {
    auto out = EventChannelHandler::open(
        INADDR_LOOPBACK, 0, std::move(users), server_.path(),
        {.log = [this](const std::string& text) { said_.push_back(text); }, .user_of = user_of_});
    EXPECT_TRUE(out) << out.error().text;
    return std::move(*out);
  }
  /// Turns until it is so.
  template <class Condition>
  void until(EventChannelHandler& handler, Condition condition) {
    for (const auto end = steady_clock::now() + seconds(60); !condition();) {
      ASSERT_LT(steady_clock::now(), end) << "never; said: " << all_said();
      pollfd waits{.fd = handler.fd(), .events = POLLIN, .revents = 0};
      ::poll(&waits, 1, 10);
      handler.turn(now_);
    }
  }
  /// Once the daemon has granted it to this program.
  void take_up(EventChannelHandler& handler, Tcp& program, std::string_view opening) {
    said_.clear();
    program.say(opening);
    until(handler, [&] { return has_said("granted, 1 to spare"); });
  }
  bool has_said(std::string_view text) const { return all_said().find(text) != std::string::npos; }
  std::string all_said() const {
    std::string out;
    for (const auto& line : said_) out += line + "\n";
    return out;
  }

  std::atomic<bool> granted_ = true;
  std::atomic<bool> hangs_up_ = false;  ///< at the next announcement
  std::mutex mutex_;
  std::string address_;
  test::Server server_{[this](const control::Request& request) { return answer(request); }};
  std::vector<std::string> said_;
  std::function<Result<uid_t>(int)> user_of_ = user_at_other_end;
  std::uint64_t now_ = 1;
  std::optional<control::Event> happened_;  ///< follows each answer; set before open()
};

TEST_F(HandlerTest, AnEventGoesFromOneProgramToTheOthers) {
  const auto handler = open();
  Tcp one(handler->port());
  Tcp other(handler->port());
  one.say(kSubscribe);
  other.say(kSubscribe);
  until(*handler, [&] { return has_said("granted, 1 to spare"); });
  until(*handler, [&] { return handler->channels() == 1 && handler->connections() == 2; });
  Tcp sonar(handler->port());
  take_up(*handler, sonar, kAnnounce);
  sonar.say(std::string(kAbc) + std::string(kEmpty));
  const std::string all = std::string(kAbc) + std::string(kEmpty);
  until(*handler, [&] { return one.heard() == all && other.heard() == all; });
  one.close();
  sonar.say(kAbc);
  until(*handler, [&] { return other.heard() == all + std::string(kAbc); });
  EXPECT_EQ(handler->connections(), 2U);
  other.close();
  sonar.close();
  until(*handler, [&] { return handler->channels() == 0; });
}

TEST_F(HandlerTest, AnEventOfAnotherSubjectEndsTheConnection) {
  const auto handler = open();
  Tcp display(handler->port());
  take_up(*handler, display, kSubscribe);
  Tcp sonar(handler->port());
  take_up(*handler, sonar, kAnnounce);
  sonar.say("\x52XXXXXXXX\0\0\0\1z"sv);
  until(*handler, [&] { return sonar.is_closed(); });
  EXPECT_TRUE(has_said("an event of 0x5858585858585858: 0x44697374616e6365 is announced"));
  EXPECT_EQ(display.heard(), "");
}

TEST_F(HandlerTest, WhatIsRefusedIsDroppedAndSaidOnce) {
  granted_ = false;
  const auto handler = open();
  Tcp sonar(handler->port());
  sonar.say(kAnnounce);
  until(*handler, [&] { return has_said("refused, 3 too many"); });
  for (int i = 0; i < 3; ++i) sonar.say(kAbc);
  until(*handler, [&] { return has_said("events are dropped: not granted"); });
  sonar.say(kAbc);
  Tcp last(handler->port());
  last.say(kSubscribe);
  until(*handler, [&] { return handler->channels() == 2; });
  EXPECT_FALSE(sonar.is_closed());
  EXPECT_EQ(std::ranges::count_if(
                said_, [](const auto& s) { return s.find("are dropped") != std::string::npos; }),
            1);
}

/// The log says what has happened, not the verdict that there is since.
TEST_F(HandlerTest, WhatHappensIsSaidInItsOwnWords) {
  happened_.emplace();
  happened_->kind = "policed";
  happened_->subject = kDistance;
  happened_->publisher = "sonar";
  happened_->message = "7 events too many";
  const auto handler = open();
  Tcp sonar(handler->port());
  sonar.say(kAnnounce);
  until(*handler, [&] { return has_said("0x44697374616e6365: policed: 7 events too many"); });
}

TEST_F(HandlerTest, WhoSaysSomethingElseIsClosed) {
  const auto handler = open();
  Tcp wrong(handler->port());
  wrong.say(
      "\x51"
      "Distance"sv);
  until(*handler, [&] { return wrong.is_closed(); });
  EXPECT_TRUE(has_said("is closed: the first octet is neither 0x50"));
  Tcp talkative(handler->port());
  talkative.say(kSubscribe);
  talkative.say("x");
  until(*handler, [&] { return talkative.is_closed(); });
  EXPECT_EQ(std::ranges::count_if(
                said_, [](const auto& s) { return s.find(" is closed: ") != std::string::npos; }),
            1)
      << "at most one a second is logged";
  now_ += 1'000'000'000;
  Tcp vast(handler->port());
  vast.say(std::string(kAnnounce) + std::string("\x52"
                                                "Distance\0\1\0\0"sv));
  until(*handler, [&] { return vast.is_closed(); });
  EXPECT_TRUE(has_said("an event of 65536 octets"));
  EXPECT_TRUE(has_said("(3 so far)"));
  EXPECT_EQ(handler->channels(), 0U);
}

/// FAMOUSO's binding for Python connects when a channel is made, and says what it wants when the
/// program announces.
TEST_F(HandlerTest, WhoSaysNothingMayStayWhereThereIsRoom) {
  const auto handler = open();
  Tcp silent(handler->port());
  silent.say(
      "\x50"
      "Dist"sv);
  until(*handler, [&] { return handler->connections() == 1; });
  now_ += 1000 * EventChannelHandler::kPatience;
  handler->turn(now_);
  EXPECT_FALSE(silent.is_closed());
  silent.say("ance"sv);
  until(*handler, [&] { return handler->channels() == 1; });
}

TEST_F(HandlerTest, WhoSaysNothingIsClosedAfterAWhileWhereThereIsNone) {
  user_of_ = [](int) -> Result<uid_t> { return 0; };
  const auto handler = open();
  Tcp silent(handler->port());
  until(*handler, [&] { return handler->connections() == 1; });
  now_ += EventChannelHandler::kPatience;
  std::vector<std::unique_ptr<Tcp>> all;
  for (std::size_t i = 1; i < EventChannelHandler::kMostConnections; ++i) {
    all.push_back(std::make_unique<Tcp>(handler->port()));
    handler->turn(now_);
  }
  until(*handler, [&] { return handler->connections() == EventChannelHandler::kMostConnections; });
  EXPECT_FALSE(silent.is_closed());
  Tcp next(handler->port());
  next.say(kSubscribe);
  until(*handler, [&] { return handler->channels() == 1; });
  EXPECT_TRUE(silent.is_closed());
  EXPECT_TRUE(has_said("it has not said what it wants"));
}

/// One that publishes once and ends, as FAMOUSO's bindings let it.
TEST_F(HandlerTest, AnEventRightBehindTheAnnouncementIsNotLost) {
  const auto handler = open();
  Tcp display(handler->port());
  take_up(*handler, display, kSubscribe);
  Tcp sonar(handler->port());
  sonar.say(std::string(kAnnounce) + std::string(kAbc));
  until(*handler, [&] { return handler->connections() == 2; });
  sonar.close();
  until(*handler, [&] { return display.heard() == kAbc; });
  until(*handler, [&] { return handler->connections() == 1 && handler->channels() == 1; });
  EXPECT_FALSE(has_said("are dropped")) << all_said();
}

TEST_F(HandlerTest, WithoutAnAnswerItIsDroppedAfterAWhile) {
  const auto handler = EventChannelHandler::open(
      INADDR_LOOPBACK, 0, {}, "/nonexistent",
      {.log = [this](const std::string& text) { said_.push_back(text); }, .user_of = user_of_});
  ASSERT_TRUE(handler) << handler.error().text;
  Tcp sonar((*handler)->port());
  sonar.say(std::string(kAnnounce) + std::string(kAbc));
  until(**handler, [&] { return (*handler)->channels() == 1; });
  now_ += EventChannelHandler::kHeld - 1;
  (*handler)->turn(now_);
  EXPECT_FALSE(has_said("are dropped"));
  now_ += 1;
  until(**handler, [&] { return has_said("events are dropped: not granted"); });
}

/// A daemon that answers a moment later is there.
TEST_F(HandlerTest, ADaemonThatIsThereIsNotSaidToBeAway) {
  const auto handler = open();
  Tcp sonar(handler->port());
  take_up(*handler, sonar, kAnnounce);
  EXPECT_FALSE(has_said("no daemon")) << all_said();
  EXPECT_FALSE(has_said("daemon-back")) << all_said();
}

TEST_F(HandlerTest, ADaemonThatGoesAndComesIsSaidOnceHoweverManyChannelsThereAre) {
  const auto handler = open();
  Tcp sonar(handler->port());
  take_up(*handler, sonar, kAnnounce);
  Tcp display(handler->port());
  take_up(*handler, display, kSubscribe);
  said_.clear();
  hangs_up_ = true;
  Tcp third(handler->port());
  third.say(
      "\x56"
      "Velocity"sv);
  until(*handler, [&] { return has_said("0x56656c6f63697479: granted, 1 to spare"); });
  const auto lines = [this](std::string_view text) {
    return std::ranges::count_if(said_, [&](const auto& s) { return s.find(text) != s.npos; });
  };
  EXPECT_EQ(lines("mlccad is gone: "), 1) << all_said();
  EXPECT_EQ(lines("mlccad answers again"), 1) << all_said();
  EXPECT_EQ(lines("0x44697374616e6365: "), 0) << "what is decided is as it was: " << all_said();
}

/// Events for programs here go through the kernel, which keeps no more than some hundred.
TEST_F(HandlerTest, NoneOfManyAtOnceIsLost) {
  const auto handler = open();
  Tcp display(handler->port());
  take_up(*handler, display, kSubscribe);
  Tcp sonar(handler->port());
  take_up(*handler, sonar, kAnnounce);
  std::string all;
  for (int i = 0; i < 3000; ++i) all += kAbc;  // 48,000 octets
  sonar.say(all);
  until(*handler, [&] { return display.heard().size() == all.size() || has_said("lost"); });
  EXPECT_EQ(display.heard(), all) << all_said();
}

TEST_F(HandlerTest, OnlyProgramsOfTheseUsersMayConnect) {
  const auto refusing = open(std::set<uid_t>{::getuid() + 1});
  Tcp one(refusing->port());
  until(*refusing, [&] { return one.is_closed(); });
  EXPECT_TRUE(has_said("of uid " + std::to_string(::getuid()) + ": it is not for programs"));
  Tcp other(refusing->port());
  until(*refusing, [&] { return other.is_closed(); });
  EXPECT_EQ(said_.size(), 1U) << "at most one line a second";
  const auto taking = open(std::set<uid_t>{::getuid()});
  Tcp third(taking->port());
  third.say(kSubscribe);
  until(*taking, [&] { return taking->channels() == 1; });
  user_of_ = [](int) -> Result<uid_t> { return fail("no socket of this host"); };
  const auto unsure = open();
  Tcp fourth(unsure->port());
  until(*unsure, [&] { return fourth.is_closed(); });
}

TEST_F(HandlerTest, OneUserHasAShareOfTheConnectionsAndLeavesTheOthers) {
  uid_t user = 1000;
  user_of_ = [&user](int) -> Result<uid_t> { return user; };
  const auto handler = open();
  std::vector<std::unique_ptr<Tcp>> all;
  const auto connect = [&](std::size_t more) {
    const std::size_t wanted = handler->connections() + more;
    for (std::size_t i = 0; i < more; ++i) {
      all.push_back(std::make_unique<Tcp>(handler->port()));
      handler->turn(now_);
    }
    until(*handler, [&] { return handler->connections() == wanted; });
  };
  connect(EventChannelHandler::kMostOfUser);
  Tcp next(handler->port());
  until(*handler, [&] { return next.is_closed(); });
  EXPECT_TRUE(has_said("user 1000 has 64 connections, the most of one user")) << all_said();
  user = 1001;
  connect(EventChannelHandler::kMostOfUser);
  user = 0;  // root may have what is left
  connect(EventChannelHandler::kMostConnections - 2 * EventChannelHandler::kMostOfUser);
  EXPECT_EQ(handler->connections(), EventChannelHandler::kMostConnections);
}

TEST_F(HandlerTest, WhoSaysNothingMakesRoomForOthersOfItsUser) {
  user_of_ = [](int) -> Result<uid_t> { return 1000; };
  const auto handler = open();
  std::vector<std::unique_ptr<Tcp>> all;
  for (std::size_t i = 0; i < EventChannelHandler::kMostOfUser; ++i) {
    all.push_back(std::make_unique<Tcp>(handler->port()));
    handler->turn(now_);
  }
  until(*handler, [&] { return handler->connections() == EventChannelHandler::kMostOfUser; });
  now_ += EventChannelHandler::kPatience;
  Tcp next(handler->port());
  next.say(kSubscribe);
  until(*handler, [&] { return handler->channels() == 1; });
  EXPECT_TRUE(all[0]->is_closed());
}

TEST_F(HandlerTest, ThereAreSoManyConnectionsAndNoMore) {
  user_of_ = [](int) -> Result<uid_t> { return 0; };
  const auto handler = open();
  std::vector<std::unique_ptr<Tcp>> all;
  for (std::size_t i = 0; i < EventChannelHandler::kMostConnections; ++i) {
    all.push_back(std::make_unique<Tcp>(handler->port()));
    handler->turn(now_);
  }
  until(*handler, [&] { return handler->connections() == EventChannelHandler::kMostConnections; });
  Tcp next(handler->port());
  until(*handler, [&] { return next.is_closed(); });
  EXPECT_EQ(handler->connections(), EventChannelHandler::kMostConnections);
  all.pop_back();
  until(*handler, [&] { return handler->connections() < EventChannelHandler::kMostConnections; });
  Tcp again(handler->port());
  until(*handler, [&] { return handler->connections() == EventChannelHandler::kMostConnections; });
  EXPECT_FALSE(again.is_closed());
}

TEST_F(HandlerTest, WhoDoesNotReadLosesEventsAndHoldsNobodyUp) {
  const auto handler = open();
  Tcp slow(handler->port());
  Tcp quick(handler->port());
  slow.say(kSubscribe);
  quick.say(kSubscribe);
  until(*handler, [&] { return handler->channels() == 1 && has_said("granted, 1"); });
  Tcp sonar(handler->port());
  take_up(*handler, sonar, kAnnounce);
  std::string event(
      "\x52"
      "Distance\0\0\xea\x60"sv);  // of 60,000 octets
  event.append(60'000, 'a');
  std::size_t sent = 0;
  until(*handler, [&] {
    if (quick.heard().size() == sent * event.size()) {
      sonar.say(event);
      ++sent;
    }
    return has_said("does not read: events of 0x44697374616e6365 are lost to it");
  });
  until(*handler, [&] { return quick.heard().size() == sent * event.size(); });
}

TEST(PeerUser, IsThatOfTheOtherSocketAndNotOurs) {
  // 127.0.0.1:40000 to 127.0.0.1:5005, of user 1000; and the other way, of user 990.
  const std::string client =
      "   3: 0100007F:9C40 0100007F:138D 01 00000000:00000000 00:00000000 00000000  1000        0 "
      "68010 1 ffff 20 4 30 10 -1";
  const std::string server =
      "   4: 0100007F:138D 0100007F:9C40 01 00000000:00000000 00:00000000 00000000   990        0 "
      "68011 1 ffff 20 4 30 10 -1";
  const TcpEnd there{.address = INADDR_LOOPBACK, .port = 40'000};
  const TcpEnd here{.address = INADDR_LOOPBACK, .port = 5005};
  EXPECT_EQ(owner_in_line(client, there, here), 1000U);
  EXPECT_EQ(owner_in_line(server, there, here), std::nullopt);
  EXPECT_EQ(owner_in_line(client, {.address = INADDR_LOOPBACK + 1, .port = 40'000}, here),
            std::nullopt);
  for (const char* other :
       {"", "  sl  local_address rem_address st", "   3: 0100007F 0100007F:138D",
        "   3: 0100007F:9C40 0100007F:138D 01 a b c -1"})
    EXPECT_EQ(owner_in_line(other, there, here), std::nullopt) << other;
  EXPECT_FALSE(user_at_other_end(-1));
  const std::string closed =
      "   3: 0100007F:9C40 0100007F:138D 05 00000000:00000000 00:00000000 00000000     0        0 "
      "0 "
      "2 ffff";
  EXPECT_EQ(owner_in_line(closed, there, here), std::nullopt)
      << "not root's: its program closed it";
}

/// Java opens an IPv6 socket and connects it to ::ffff:127.0.0.1.
TEST(PeerUser, IsThatOfAnIpv6SocketThatSpeaksIpv4) {
  const TcpEnd there{.address = INADDR_LOOPBACK, .port = 40'000};
  const TcpEnd here{.address = INADDR_LOOPBACK, .port = 5005};
  const auto line = [](const std::string& before) {
    return "   3: " + before + "0100007F:9C40 " + before +
           "0100007F:138D 01 00000000:00000000 00:00000000 00000000  1000        0 68010 1 ff";
  };
  EXPECT_EQ(owner_in_line(line("0000000000000000FFFF0000"), there, here), 1000U);
  for (const char* other : {"000000000000000000000000", "0000000001000000FFFF0000", "FFFF0000"})
    EXPECT_EQ(owner_in_line(line(other), there, here), std::nullopt) << other;
}

TEST_F(HandlerTest, AProgramMayConnectByAnIpv6Socket) {
  const Fd socket(::socket(AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0));
  ASSERT_TRUE(socket) << "IPv6 is needed";
  const auto handler = open(std::set<uid_t>{::getuid()});
  sockaddr_in6 at{};
  at.sin6_family = AF_INET6;
  at.sin6_port = htons(handler->port());
  ASSERT_EQ(::inet_pton(AF_INET6, "::ffff:127.0.0.1", &at.sin6_addr), 1);
  ASSERT_EQ(::connect(socket.get(), reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
  ASSERT_EQ(::send(socket.get(), kSubscribe.data(), kSubscribe.size(), MSG_NOSIGNAL), 9);
  until(*handler, [&] { return handler->channels() == 1 || has_said("refused: "); });
  EXPECT_EQ(handler->channels(), 1U) << all_said();
}

}  // namespace
}  // namespace mlcca::relay
