// SPDX-License-Identifier: BSD-2-Clause
// Whoever is granted a channel sends to that one alone, as long as it is granted. What its
// subscribers do not read is lost, bounded, and counted.
#include <fmt/core.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "client/local_numbers.hpp"
#include "client/local_senders.hpp"
#include "client/local_socket.hpp"
#include "control/codec.hpp"
#include "tests/client/events_scene.hpp"

namespace mlcca::client {
namespace {

constexpr std::uint64_t kOther = 0x6f74686572000000;
constexpr std::array<std::uint8_t, 2> kGo{'g', 'o'};
/// More than any queue has: net.unix.max_dgram_qlen.
constexpr unsigned kFlood = 2000;

/// Of a subject, with what is granted on the gateway itself.
std::string reply_of(std::uint64_t subject, const std::vector<std::string>& publishers,
                     const std::vector<control::Endpoint>& endpoints) {
  control::Channels channels;
  channels.channels.emplace_back().subject = subject;
  for (const std::string& publisher : publishers) {
    control::Channel& row = channels.channels.emplace_back();
    row.subject = subject;
    row.publisher = publisher;
    row.from = row.to = "panel";
    row.granted = true;
  }
  channels.endpoints = endpoints;
  return encode(control::Reply{.id = 1, .body = std::move(channels)});
}

class LocalQueue : public EventsInC {
 protected:
  std::string address(std::uint64_t end) { return mlcca_events_address(subscriber_.get(), end); }
  void follow(std::uint64_t end, std::uint64_t subject,
              const std::vector<std::string>& publishers = {"lever"}) {
    ASSERT_EQ(use(subscriber_, end, MLCCA_SUBSCRIBER,
                  reply_of(subject, publishers, {from_programs_of(::getuid())})),
              "");
  }
  void publish_to(std::uint64_t end, std::uint64_t subject, const std::string& where) {
    ASSERT_EQ(use(publisher_, end, MLCCA_PUBLISHER, reply_of(subject, {}, {to_program(where)})),
              "");
  }
  mlcca_published publish_of(std::uint64_t end) {
    return mlcca_events_publish(publisher_.get(), end, kGo.data(), kGo.size());
  }
  /// How many events the subscriber is said to have missed; it waits until it is said so.
  std::uint64_t missed() {
    std::uint64_t end = 0;
    std::string reply(4096, '?');
    for (;;) {
      const std::size_t size =
          mlcca_events_happened(subscriber_.get(), &end, reply.data(), reply.size());
      if (size != 0) {
        control::Buffer buffer;
        buffer.append(std::string_view(reply).substr(0, size));
        const auto decoded = control::decode_reply(buffer);
        if (!decoded || !*decoded) return 0;
        const auto& event = std::get<control::Event>((*decoded)->body);
        EXPECT_EQ(event.kind, "missed");
        return event.missing;
      }
      std::array waits{
          pollfd{.fd = mlcca_events_fd(subscriber_.get()), .events = POLLIN, .revents = 0},
          pollfd{.fd = mlcca_events_fd(publisher_.get()), .events = POLLIN, .revents = 0}};
      if (::poll(waits.data(), waits.size(), 60'000) <= 0) return 0;
      taken_ += came().size();
      Came none;
      mlcca_events_process(publisher_.get(), Came::take, &none);
    }
  }
  std::uint64_t taken_ = 0;
};

TEST_F(LocalQueue, AFloodOfOneChannelTakesNothingFromAnother) {
  const std::string stop = address(3);
  const std::string other = address(4);
  ASSERT_NE(name_in(stop), name_in(other)) << "each has a queue of its own";
  follow(3, kStop);
  follow(4, kOther);
  publish_to(7, kStop, stop);
  publish_to(8, kOther, other);
  for (unsigned i = 0; i < kFlood; ++i) static_cast<void>(publish_of(7));
  EXPECT_EQ(publish_of(7), MLCCA_LOST) << "it does not wait";
  EXPECT_EQ(publish_of(8), MLCCA_SENT);
  std::vector<std::string> all;
  while (is_readable())
    for (std::string& one : came()) all.push_back(std::move(one));
  EXPECT_EQ(std::ranges::count(all, "4 go"), 1);
  Came none;
  mlcca_events_process(publisher_.get(), Came::take, &none);  // it reports what was lost
  static_cast<void>(came());
  const std::uint64_t lost = mlcca_events_lost(subscriber_.get());
  EXPECT_GT(lost, 0U);
  EXPECT_EQ(mlcca_events_lost_of(subscriber_.get(), 3), lost);
  EXPECT_EQ(mlcca_events_lost_of(subscriber_.get(), 4), 0U) << "each channel has its own count";
  EXPECT_EQ(mlcca_events_lost_of(subscriber_.get(), 5), 0U);
}

TEST_F(LocalQueue, WhatABurstLosesIsReportedThoughNothingFollows) {
  follow(3, kStop);
  publish_to(7, kStop, address(3));
  unsigned lost = 0;
  for (unsigned i = 0; i < kFlood; ++i) lost += publish_of(7) == MLCCA_LOST ? 1 : 0;
  ASSERT_GT(lost, 0U);
  EXPECT_EQ(missed(), lost);
  EXPECT_EQ(taken_ + lost, kFlood);
  EXPECT_EQ(mlcca_events_lost(subscriber_.get()), lost);
}

TEST_F(LocalQueue, AChannelThatTwoEndsFollowHasOneAddress) {
  const std::string first = address(3);
  follow(3, kStop);
  ASSERT_NE(address(4), first);
  follow(4, kStop);
  EXPECT_EQ(address(4), first) << "it is to be announced again";
  publish_to(7, kStop, first);
  EXPECT_EQ(publish("go"), MLCCA_SENT);
  EXPECT_EQ(came(), (std::vector<std::string>{"3 go", "4 go"}));
}

/// It keeps its socket and the key, and goes on; another publisher of the same user is granted.
TEST_F(LocalQueue, WhoHasLostItsGrantSendsInVain) {
  const std::string before = address(3);
  follow(3, kStop, {"lever", "button"});
  EXPECT_EQ(address(3), before);
  auto withdrawn = LocalSender::open(control::local_address_in(before).value());
  ASSERT_TRUE(withdrawn);
  publish_to(7, kStop, before);
  ASSERT_EQ(withdrawn->send(kStop, kGo), LocalSender::Sent::sent);
  ASSERT_EQ(publish("button"), MLCCA_SENT);
  EXPECT_EQ(came(), (std::vector<std::string>{"3 go", "3 button"}));

  follow(3, kStop, {"button"});
  const std::string after = address(3);
  EXPECT_EQ(name_in(after), name_in(before));
  EXPECT_NE(key_in(after), key_in(before));
  for (unsigned i = 0; i < kFlood; ++i) static_cast<void>(withdrawn->send(kStop, kGo));
  EXPECT_FALSE(is_readable()) << "the kernel keeps none of them";
  EXPECT_EQ(publish("with the former key"), MLCCA_SENT) << "it does not know yet";
  publish_to(7, kStop, after);
  EXPECT_EQ(publish("button"), MLCCA_SENT);
  EXPECT_EQ(came(), std::vector<std::string>{"3 button"});
  EXPECT_EQ(missed(), 1U) << "what was sent meanwhile is counted";
}

/// The names of all sockets are in /proc/net/unix; the keys are not.
TEST_F(LocalQueue, WhoStatesTheNameOfAnotherUsersReceiverCountsNothingForIt) {
  const std::string own = address(3);
  follow(3, kStop);
  auto strange = control::local_address_in(own).value();
  strange.key = ~strange.key;
  const std::vector both{to_program(control::to_text(strange), ::getuid() + 1), to_program(own)};
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_of(kStop, {}, both)), "");
  for (int i = 0; i < 3; ++i) ASSERT_EQ(publish("go"), MLCCA_SENT);
  EXPECT_EQ(came(), (std::vector<std::string>{"3 go", "3 go", "3 go"}));
  EXPECT_EQ(mlcca_events_lost(subscriber_.get()), 0U);
}

/// Sockets are closed and opened again, because there are more receivers than it keeps open.
TEST_F(LocalQueue, LossesAreCountedOfMoreReceiversThanSocketsAreOpen) {
  constexpr std::size_t receivers = LocalSenders::kMostOpen + 44;
  constexpr unsigned events = 700;
  std::vector<LocalReceiver> all;
  std::vector<control::Endpoint> to;
  for (std::size_t i = 0; i < receivers; ++i) {
    all.push_back(LocalReceiver::open().value());
    to.push_back(to_program(all.back().address()));
  }
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_of(kStop, {}, to)), "");
  for (unsigned i = 0; i < events; ++i) static_cast<void>(publish_of(7));
  std::vector<std::uint8_t> buffer(LocalReceiver::kBuffer);
  std::vector<std::uint64_t> counted(receivers);
  const auto read_all = [&] {
    for (std::size_t i = 0; i < receivers; ++i)
      all[i].receive(events, buffer, [&counted, i](const LocalEvent& event) {
        counted[i] += event.missed + (event.is_notice ? 0 : 1);
      });
  };
  read_all();
  // No event follows: the publisher reports what was lost where there is room again.
  Came none;
  pollfd waits{.fd = mlcca_events_fd(publisher_.get()), .events = POLLIN, .revents = 0};
  while (std::ranges::any_of(counted, [](std::uint64_t one) { return one != events; }) &&
         ::poll(&waits, 1, 10'000) == 1) {
    mlcca_events_process(publisher_.get(), Came::take, &none);
    read_all();
  }
  EXPECT_EQ(std::ranges::count(counted, events), receivers);
}

TEST_F(LocalQueue, WithoutADescriptorTheLimitIsNamed) {
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit few{.rlim_cur = 3, .rlim_max = before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &few), 0);
  EXPECT_EQ(address(9), "");
  EXPECT_EQ(
      use(subscriber_, 9, MLCCA_SUBSCRIBER,
          reply_of(kOther, {"lever"}, {from_programs_of(::getuid())})),
      "programs on this gateway: socket: Too many open files (each subscribed channel takes a "
      "file descriptor, and this process may have 3)");
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_NE(address(9), "");
}

TEST_F(LocalQueue, MoreReceiversThanAreCountedAreRefused) {
  std::vector<control::Endpoint> to;
  for (std::size_t i = 0; i <= LocalSenders::kMost; ++i)
    to.push_back(to_program(control::to_text({.name = fmt::format("{:05x}", i), .key = i})));
  EXPECT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_of(kStop, {}, to)),
            "programs on this gateway: there are 4097 receivers, and a program sends to at most "
            "4096");
  to.pop_back();
  EXPECT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_of(kStop, {}, to)), "");
}

TEST_F(LocalQueue, AChannelThatIsGoneHasAnotherKeyAsWell) {
  const std::string before = address(3);
  follow(3, kStop);
  ASSERT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER, encode(control::Reply{.body = control::Error{}})),
            "");
  EXPECT_NE(address(3), before);
  // Of an end that has left nobody holds the publishers against the grants.
  const std::string second = address(3);
  follow(3, kStop);
  mlcca_events_leave(subscriber_.get(), 3);
  static_cast<void>(address(4));
  follow(4, kStop);
  EXPECT_EQ(name_in(address(4)), name_in(second));
  EXPECT_NE(key_in(address(4)), key_in(second));
}

TEST_F(LocalQueue, TheKeyOfOneChannelSendsNoOther) {
  const std::string stop = address(3);
  static_cast<void>(address(4));
  follow(3, kStop);
  follow(4, kOther);
  publish_to(7, kOther, stop);
  EXPECT_EQ(publish("go"), MLCCA_SENT);
  EXPECT_EQ(came(), std::vector<std::string>{});
}

TEST(LocalNumbersTest, GapsAreCountedOfEachSender) {
  constexpr uid_t user = 1000;
  LocalNumbers numbers;
  EXPECT_EQ(numbers.missed(user, 1, 0, false), 0U);
  EXPECT_EQ(numbers.missed(user, 1, 1, false), 0U);
  EXPECT_EQ(numbers.missed(user, 1, 5, false), 3U);
  EXPECT_EQ(numbers.missed(user, 2, 4, false), 4U) << "it begins at 0";
  EXPECT_EQ(numbers.missed(user + 1, 1, 0, false), 0U) << "another user's number is another one";
  EXPECT_EQ(numbers.missed(user, 1, 8, true), 2U);
  EXPECT_EQ(numbers.missed(user, 1, 8, true), 0U) << "a notice is no event";
  EXPECT_EQ(numbers.missed(user, 1, 8, false), 0U);
  EXPECT_EQ(numbers.missed(user, 1, 3, false), 0U) << "it counts otherwise now";
  EXPECT_EQ(numbers.missed(user, 1, 4, false), 0U);
  LocalNumbers wrapped;
  EXPECT_EQ(wrapped.missed(user, 1, 0x7fffffff, false), 0x7fffffffU);
  EXPECT_EQ(wrapped.missed(user, 1, 0xfffffffe, false), 0x7ffffffeU);
  EXPECT_EQ(wrapped.missed(user, 1, 1, false), 2U) << "after 2^32 - 1 comes 0";
}

TEST(LocalNumbersTest, AUserMakesOthersForgetNothing) {
  LocalNumbers numbers;
  EXPECT_EQ(numbers.missed(1, 7, 0, false), 0U);
  for (std::uint32_t sender = 0; sender < 1000; ++sender) {
    EXPECT_EQ(numbers.missed(2, sender, 0, false), 0U);
    EXPECT_EQ(numbers.missed(3, sender, 0, false), 0U);
  }
  EXPECT_LE(numbers.senders(), 1 + 2 * LocalNumbers::kMostOfUser);
  EXPECT_EQ(numbers.missed(1, 7, 3, false), 2U);
  EXPECT_EQ(numbers.missed(2, 5, 900, false), 0U) << "it may be one that was forgotten";
  for (uid_t user = 10; user < 1000; ++user)
    EXPECT_EQ(numbers.missed(user, 1, 0, false), 0U) << user;
  EXPECT_LE(numbers.senders(), LocalNumbers::kMost);
}

}  // namespace
}  // namespace mlcca::client
