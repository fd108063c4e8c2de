// SPDX-License-Identifier: BSD-2-Clause
// A daemon that has restarted knows no receiver on the gateway until its program has announced it
// again. What is published meanwhile arrives, or is counted.
#include <gtest/gtest.h>
#include <poll.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "base/clock.hpp"
#include "tests/client/events_scene.hpp"

namespace mlcca::client {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr std::uint64_t kForEver = ~std::uint64_t{0};

/// The answer of a daemon to a publisher or a subscriber of programs on the gateway.
std::string answer(bool granted, const std::vector<control::Endpoint>& endpoints,
                   std::uint64_t grace = 10 * kSecond) {
  control::Channels channels;
  control::Channel& row = channels.channels.emplace_back();
  row.subject = kStop;
  row.publisher = "lever";
  row.from = row.to = "panel";
  row.granted = granted;
  channels.endpoints = endpoints;
  channels.grace_ns = grace;
  return encode(control::Reply{.id = 1, .body = std::move(channels)});
}

class LocalRestart : public EventsInC {
 protected:
  void SetUp() override {
    ASSERT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER, answer(true, {from_programs_of(::getuid())})),
              "");
    know();
  }
  /// The daemon knows the subscriber.
  void know() {
    ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, answer(true, {to_program(address_)})), "");
  }
  /// The daemon does not know it yet.
  void know_nobody(bool granted = true, std::uint64_t grace = 10 * kSecond) {
    ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, answer(granted, {}, grace)), "");
  }
  /// The kind of the next thing that has happened to the ends of a program, and what is said.
  static std::pair<std::string, std::string> happened(const Events& events) {
    std::uint64_t end = 0;
    std::string reply(4096, '?');
    pollfd waits{.fd = mlcca_events_fd(events.get()), .events = POLLIN, .revents = 0};
    std::size_t size = 0;
    while ((size = mlcca_events_happened(events.get(), &end, reply.data(), reply.size())) == 0) {
      if (::poll(&waits, 1, 60'000) <= 0) return {};
      Came none;
      mlcca_events_process(events.get(), Came::take, &none);
    }
    control::Buffer buffer;
    buffer.append(std::string_view(reply).substr(0, size));
    const auto decoded = control::decode_reply(buffer);
    if (!decoded || !*decoded) return {};
    const auto& event = std::get<control::Event>((*decoded)->body);
    return {event.kind, event.message};
  }
  [[nodiscard]] std::uint64_t lost() const { return mlcca_events_lost_of(subscriber_.get(), 3); }
};

TEST_F(LocalRestart, NothingIsLostUntilTheReceiverIsKnownAgain) {
  EXPECT_EQ(publish("1"), MLCCA_SENT);
  know_nobody();
  EXPECT_EQ(publish("2"), MLCCA_SENT);
  know_nobody();  // asked again for another reason
  EXPECT_EQ(publish("3"), MLCCA_SENT);
  know();
  EXPECT_EQ(publish("4"), MLCCA_SENT);
  EXPECT_EQ(came(), (std::vector<std::string>{"3 1", "3 2", "3 3", "3 4"}));
  EXPECT_EQ(lost(), 0U);
}

TEST_F(LocalRestart, AReceiverThatWasNeverSentToIsKeptAsWell) {
  know_nobody();
  EXPECT_EQ(publish("1"), MLCCA_SENT);
  EXPECT_EQ(came(), std::vector<std::string>{"3 1"});
  EXPECT_EQ(lost(), 0U);
}

TEST_F(LocalRestart, AProgramThatSubscribesToItselfKeepsItsReceiver) {
  const std::string own = mlcca_events_address(subscriber_.get(), 3);
  ASSERT_EQ(use(subscriber_, 8, MLCCA_PUBLISHER, answer(true, {to_program(own)})), "");
  ASSERT_EQ(use(subscriber_, 8, MLCCA_PUBLISHER, answer(true, {})), "");
  EXPECT_EQ(mlcca_events_publish(subscriber_.get(), 8, "1", 1), MLCCA_SENT);
  EXPECT_EQ(came(), std::vector<std::string>{"3 1"});
}

TEST_F(LocalRestart, AnotherKeyOfTheReceiverReplacesTheFormerOne) {
  EXPECT_EQ(publish("1"), MLCCA_SENT);
  know_nobody();
  const std::string before = address_;
  ASSERT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER, encode(control::Reply{.body = control::Error{}})),
            "");
  const std::string after = mlcca_events_address(subscriber_.get(), 3);
  ASSERT_NE(after, before);
  ASSERT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER, answer(true, {from_programs_of(::getuid())})),
            "");
  EXPECT_EQ(publish("2"), MLCCA_SENT) << "it does not know yet";
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, answer(true, {to_program(after)})), "");
  EXPECT_EQ(publish("3"), MLCCA_SENT);
  EXPECT_EQ(came(), (std::vector<std::string>{"3 1", "3 3"}));
  EXPECT_EQ(lost(), 1U);
}

TEST_F(LocalRestart, WhoIsNotGrantedKeepsNoReceiver) {
  know_nobody(false);
  EXPECT_EQ(publish("1"), MLCCA_NOT_GRANTED);
  EXPECT_EQ(came(), std::vector<std::string>{});
}

TEST_F(LocalRestart, AReceiverThatHasEndedIsNotKept) {
  subscriber_.reset();
  know_nobody();
  EXPECT_EQ(publish("1"), MLCCA_NOT_GRANTED);
}

TEST_F(LocalRestart, AReceiverThatEndsLaterIsForgotten) {
  know_nobody();
  EXPECT_EQ(publish("1"), MLCCA_SENT);
  subscriber_.reset();
  EXPECT_EQ(publish("2"), MLCCA_NOT_GRANTED);
  EXPECT_EQ(publish("3"), MLCCA_NOT_GRANTED);
}

/// Its program may sleep. It counts what it has not been sent when it is known again, or before.
TEST_F(LocalRestart, AfterTheGraceNothingIsSentToIt) {
  EXPECT_EQ(publish("1"), MLCCA_SENT);
  know_nobody(true, 1);
  EXPECT_EQ(publish("2"), MLCCA_NOT_GRANTED);
  EXPECT_EQ(publish("3"), MLCCA_NOT_GRANTED);
  know();
  EXPECT_EQ(publish("4"), MLCCA_SENT);
  EXPECT_EQ(came(), (std::vector<std::string>{"3 1", "3 4"}));
  EXPECT_EQ(lost(), 2U);
}

TEST_F(LocalRestart, ALongGraceDoesNotOverflow) {
  know_nobody(true, kForEver);
  EXPECT_EQ(publish("1"), MLCCA_SENT);
  EXPECT_EQ(came(), std::vector<std::string>{"3 1"});
}

// --- a daemon that is gone for longer than its grace, or stops
// ------------------------------------

TEST_F(LocalRestart, WithinTheGraceEventsGoOn) {
  for (const Events* events : {&publisher_, &subscriber_})
    mlcca_events_gone(events->get(), monotonic_ns());
  EXPECT_EQ(publish("1"), MLCCA_SENT);
  EXPECT_EQ(came(), std::vector<std::string>{"3 1"});
  EXPECT_EQ(lost(), 0U);
}

TEST_F(LocalRestart, APublisherWhoseGraceIsOverSendsNothingAndItIsCounted) {
  EXPECT_EQ(publish("1"), MLCCA_SENT);
  mlcca_events_gone(publisher_.get(), monotonic_ns() - 10 * kSecond);
  EXPECT_EQ(publish("2"), MLCCA_LOST);
  EXPECT_EQ(happened(publisher_),
            std::pair(std::string("lapsed"),
                      std::string("mlccad has not answered for its grace, 10 s: the gates close, "
                                  "and events between programs on this gateway are not "
                                  "delivered")));
  mlcca_events_gone(publisher_.get(), monotonic_ns());
  EXPECT_EQ(publish("3"), MLCCA_LOST) << "it was gone before";
  EXPECT_EQ(came(), std::vector<std::string>{"3 1"});
  EXPECT_EQ(lost(), 2U) << "before another event follows";
  know();
  EXPECT_EQ(publish("4"), MLCCA_SENT);
  EXPECT_EQ(came(), std::vector<std::string>{"3 4"});
  EXPECT_EQ(lost(), 2U);
}

TEST_F(LocalRestart, ASubscriberWhoseGraceIsOverTakesNothingAndCountsIt) {
  mlcca_events_gone(subscriber_.get(), monotonic_ns() - 10 * kSecond);
  EXPECT_EQ(publish("1"), MLCCA_SENT) << "its daemon is there";
  EXPECT_EQ(came(), std::vector<std::string>{});
  EXPECT_EQ(lost(), 1U);
  EXPECT_EQ(mlcca_events_lost(subscriber_.get()), 1U);
  EXPECT_EQ(happened(subscriber_).first, "lapsed");
  EXPECT_EQ(happened(subscriber_).first, "missed");
  ASSERT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER, answer(true, {from_programs_of(::getuid())})),
            "");
  EXPECT_EQ(publish("2"), MLCCA_SENT);
  EXPECT_EQ(came(), std::vector<std::string>{"3 2"});
  EXPECT_EQ(lost(), 1U);
}

TEST_F(LocalRestart, TheGraceIsThatOfTheDaemon) {
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, answer(true, {to_program(address_)}, kSecond / 20)),
            "");
  mlcca_events_gone(publisher_.get(), monotonic_ns());
  EXPECT_EQ(happened(publisher_).second.substr(0, 44),
            "mlccad has not answered for its grace, 50 ms");
  EXPECT_EQ(publish("1"), MLCCA_LOST);
}

TEST_F(LocalRestart, AGraceForEverDoesNotEnd) {
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, answer(true, {to_program(address_)}, kForEver)),
            "");
  mlcca_events_gone(publisher_.get(), 1);
  EXPECT_EQ(publish("1"), MLCCA_SENT);
}

TEST_F(LocalRestart, WhoIsGrantedNothingIsNotToldThatItEnds) {
  know_nobody(false);
  mlcca_events_gone(publisher_.get(), monotonic_ns() - 20 * kSecond);
  Came none;
  mlcca_events_process(publisher_.get(), Came::take, &none);
  std::uint64_t end = 0;
  EXPECT_EQ(mlcca_events_happened(publisher_.get(), &end, nullptr, 0), 0U);
}

TEST_F(LocalRestart, ADaemonThatStopsEndsThemAtOnce) {
  EXPECT_EQ(publish("1"), MLCCA_SENT);
  mlcca_events_close(publisher_.get(), 7);
  mlcca_events_gone(publisher_.get(), monotonic_ns());
  EXPECT_EQ(publish("2"), MLCCA_LOST);
  mlcca_events_close(subscriber_.get(), 3);
  EXPECT_EQ(came(), std::vector<std::string>{});
  EXPECT_EQ(lost(), 2U);
}

TEST_F(LocalRestart, AProgramThatSubscribesToItselfCountsAsWell) {
  const std::string own = mlcca_events_address(subscriber_.get(), 3);
  ASSERT_EQ(use(subscriber_, 8, MLCCA_PUBLISHER, answer(true, {to_program(own)})), "");
  for (const std::uint64_t end : {3U, 8U}) mlcca_events_close(subscriber_.get(), end);
  mlcca_events_close(subscriber_.get(), 99);  // unknown
  EXPECT_EQ(mlcca_events_publish(subscriber_.get(), 8, "1", 1), MLCCA_LOST);
  ASSERT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER, answer(true, {from_programs_of(::getuid())})),
            "");
  ASSERT_EQ(use(subscriber_, 8, MLCCA_PUBLISHER, answer(true, {to_program(own)})), "");
  EXPECT_EQ(mlcca_events_publish(subscriber_.get(), 8, "2", 1), MLCCA_SENT);
  EXPECT_EQ(came(), std::vector<std::string>{"3 2"});
  EXPECT_EQ(lost(), 1U);
}

}  // namespace
}  // namespace mlcca::client
