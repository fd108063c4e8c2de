// SPDX-License-Identifier: BSD-2-Clause
// The data plane in C, between two of a process, as two programs on a gateway.
#include "mlcca/client/events.h"

#include <gtest/gtest.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "control/codec.hpp"

namespace mlcca::client {
namespace {

constexpr std::uint64_t kSubject = 0x73746f7000000000;

struct Free {
  void operator()(mlcca_events* events) const { mlcca_events_free(events); }
};
using Events = std::unique_ptr<mlcca_events, Free>;

std::string reply_with(const std::vector<control::Endpoint>& endpoints) {
  control::Channels channels;
  channels.channels.emplace_back().subject = kSubject;
  channels.endpoints = endpoints;
  return encode(control::Reply{.id = 1, .body = std::move(channels)});
}

control::Endpoint to_program(const std::string& address) {
  control::Endpoint out;
  out.local = address;
  return out;
}
control::Endpoint from_programs_of(std::uint32_t user) {
  control::Endpoint out;
  out.user = user;
  return out;
}

/// What is wrong; empty: nothing.
std::string use(const Events& events, std::uint64_t end, mlcca_role role, const std::string& reply,
                std::size_t room = 200) {
  std::string why(room, '?');
  const int done =
      mlcca_events_use(events.get(), end, role, reply.data(), reply.size(), why.data(), room);
  why.resize(room == 0 ? 0 : std::char_traits<char>::length(why.c_str()));
  EXPECT_EQ(done, why.empty() && room != 0 ? 0 : -1);
  return why;
}

struct Came {
  std::vector<std::string> all;
  static void take(void* context, std::uint64_t end, const void* data, std::size_t size,
                   const char* network, std::uint64_t unix_ns) {
    EXPECT_STREQ(network, "");
    EXPECT_GT(unix_ns, 1'600'000'000'000'000'000U);
    static_cast<Came*>(context)->all.push_back(std::to_string(end) + " " +
                                               std::string(static_cast<const char*>(data), size));
  }
};

class EventsInC : public ::testing::Test {
 protected:
  std::vector<std::string> came() {
    Came out;
    mlcca_events_process(subscriber_.get(), Came::take, &out);
    return out.all;
  }
  bool is_readable() {
    pollfd waits{.fd = mlcca_events_fd(subscriber_.get()), .events = POLLIN, .revents = 0};
    return ::poll(&waits, 1, 0) == 1;
  }
  mlcca_published publish(const std::string& text) {
    return mlcca_events_publish(publisher_.get(), 7, text.data(), text.size());
  }

  Events publisher_{mlcca_events_new()};
  Events subscriber_{mlcca_events_new()};
  const std::string address_ = mlcca_events_address(subscriber_.get());
};

TEST_F(EventsInC, AnEventGoesFromOneProgramToTheOther) {
  ASSERT_EQ(address_.size(), 5U);
  EXPECT_EQ(publish("early"), MLCCA_NOT_GRANTED);
  EXPECT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_with({to_program(address_)})), "");
  EXPECT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER, reply_with({from_programs_of(::getuid())})), "");
  EXPECT_FALSE(is_readable());
  EXPECT_EQ(publish("go"), MLCCA_SENT);
  EXPECT_EQ(publish(""), MLCCA_SENT);
  EXPECT_TRUE(is_readable());
  EXPECT_EQ(came(), (std::vector<std::string>{"3 go", "3 "}));
  EXPECT_FALSE(is_readable());
  EXPECT_EQ(mlcca_events_lost(subscriber_.get()), 0U);
}

TEST_F(EventsInC, WhatIsNotGrantedNeitherGoesNorComes) {
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_with({to_program(address_)})), "");
  ASSERT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER, reply_with({from_programs_of(::getuid() + 1)})),
            "");
  EXPECT_EQ(publish("of another user"), MLCCA_SENT);
  EXPECT_EQ(came(), std::vector<std::string>{});
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_with({})), "");
  EXPECT_EQ(publish("go"), MLCCA_NOT_GRANTED);
  const control::Reply error{.id = 1, .body = control::Error{}};
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_with({to_program(address_)})), "");
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, encode(error)), "");
  EXPECT_EQ(publish("go"), MLCCA_NOT_GRANTED);
}

TEST_F(EventsInC, AnEndThatHasLeftIsGone) {
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_with({to_program(address_)})), "");
  ASSERT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER, reply_with({from_programs_of(::getuid())})), "");
  EXPECT_EQ(publish("go"), MLCCA_SENT);
  mlcca_events_leave(subscriber_.get(), 3);
  EXPECT_EQ(came(), std::vector<std::string>{});
  mlcca_events_leave(publisher_.get(), 7);
  mlcca_events_leave(publisher_.get(), 7);
  EXPECT_EQ(publish("go"), MLCCA_NOT_GRANTED);
}

/// By a timer of its own: nothing comes any more that would find it.
TEST_F(EventsInC, APartOfAnEventIsGivenUpOnTime) {
  control::Endpoint field;
  field.network = "field";
  field.interface = "lo";
  field.ifindex = ::if_nametoindex("lo");
  ASSERT_EQ(use(subscriber_, 1, MLCCA_SUBSCRIBER, reply_with({field})), "");
  const int sender = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(9999);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string first("stop\0\0\0\0\1\x61\0\0\0\0\7", 15);  // of two fragments, the number 7
  first.resize(9 + 8183, 'a');
  ASSERT_EQ(
      ::sendto(sender, first.data(), first.size(), 0, reinterpret_cast<sockaddr*>(&to), sizeof to),
      static_cast<ssize_t>(first.size()));
  ::close(sender);
  while (mlcca_events_lost(subscriber_.get()) == 0) {
    pollfd waits{.fd = mlcca_events_fd(subscriber_.get()), .events = POLLIN, .revents = 0};
    ASSERT_EQ(::poll(&waits, 1, 20'000), 1) << "the memory would stay";
    EXPECT_TRUE(came().empty());
  }
  EXPECT_EQ(mlcca_events_lost(subscriber_.get()), 1U);
  EXPECT_FALSE(is_readable());
}

TEST_F(EventsInC, AnEventMayHaveSoManyBytesAndNoMore) {
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_with({to_program(address_)})), "");
  ASSERT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER, reply_with({from_programs_of(::getuid())})), "");
  EXPECT_EQ(publish(std::string(65'535, 'a')), MLCCA_SENT);
  EXPECT_EQ(publish(std::string(65'536, 'a')), MLCCA_TOO_LONG);
  EXPECT_EQ(came(), std::vector<std::string>{"3 " + std::string(65'535, 'a')});
}

TEST_F(EventsInC, WhatIsNoReplyIsSaid) {
  const std::string good = reply_with({to_program(address_)});
  const std::string none = "what is given is not one reply";
  EXPECT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, ""), none);
  EXPECT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, good.substr(0, good.size() - 1)), none);
  EXPECT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, good + good), none);
  EXPECT_NE(use(publisher_, 7, MLCCA_PUBLISHER, "\x05\xff\xff\xff\xff\xff"), "");
  EXPECT_EQ(publish("go"), MLCCA_NOT_GRANTED);
  control::Endpoint nowhere;
  nowhere.network = "field";
  nowhere.interface = "none0";
  nowhere.ifindex = 999'999;
  EXPECT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_with({nowhere}), 8), "field: ");
  static_cast<void>(use(publisher_, 7, MLCCA_PUBLISHER, reply_with({nowhere}), 0));
}

}  // namespace
}  // namespace mlcca::client
