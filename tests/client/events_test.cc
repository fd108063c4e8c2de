// SPDX-License-Identifier: BSD-2-Clause
// The data plane in C, between two of a process, as two programs on a gateway.
#include "mlcca/client/events.h"

#include <gtest/gtest.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/handle.hpp"
#include "base/unix_address.hpp"
#include "client/local_senders.hpp"
#include "client/local_socket.hpp"
#include "tests/client/events_scene.hpp"

namespace mlcca::client {
namespace {

TEST_F(EventsInC, AnEventGoesFromOneProgramToTheOther) {
  ASSERT_EQ(address_.size(), 21U);
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

/// The name of its socket is in /proc/net/unix; the key, of 64 bits, is nowhere.
TEST_F(EventsInC, WhoDoesNotKnowTheKeyFillsNoQueue) {
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_with({to_program(address_)})), "");
  ASSERT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER, reply_with({from_programs_of(::getuid())})), "");
  const std::string event = std::string("stop\0\0\0\0", 8) + "flood";
  const std::string key = key_in(address_);
  std::vector<std::string> all{
      "",         event, event + event, std::string(65'000, 's'), std::string(8, '\0') + event,
      event + key};
  for (std::size_t octets = 0; octets < key.size(); ++octets) all.push_back(key.substr(0, octets));
  for (std::size_t bit = 0; bit < 8 * key.size(); ++bit) {
    std::string other = key;
    other[bit / 8] = static_cast<char>(other[bit / 8] ^ 1 << bit % 8);
    all.push_back(other + event);
  }
  send_as_another_user(name_in(address_), all);
  EXPECT_FALSE(is_readable()) << "the kernel keeps none of them";
  EXPECT_EQ(publish("go"), MLCCA_SENT);
  EXPECT_EQ(came(), std::vector<std::string>{"3 go"});
}

/// Whoever knows it is held against the users that are granted.
TEST_F(EventsInC, TheKeyAloneMakesNoPublisher) {
  // Neither that of this program nor nobody, as whom the other one sends where it may.
  const uid_t granted = ::getuid() + 1;
  ASSERT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER, reply_with({from_programs_of(granted)})), "");
  send_as_another_user(name_in(address_),
                       {key_in(address_) + std::string("stop\0\0\0\0", 8) + "false"});
  EXPECT_TRUE(is_readable());
  for (int i = 0; i < 600 && is_readable(); ++i) EXPECT_EQ(came(), std::vector<std::string>{});
  EXPECT_FALSE(is_readable());
}

TEST_F(EventsInC, EveryReceiverHasAnotherKey) {
  const Events other{mlcca_events_new()};
  const std::string address = mlcca_events_address(other.get(), 3);
  EXPECT_NE(name_in(address), name_in(address_));
  EXPECT_NE(address.substr(5), address_.substr(5));
  EXPECT_EQ(mlcca_events_address(other.get(), 3), address) << "it keeps its own";
  // With the key of another one nothing comes.
  ASSERT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER, reply_with({from_programs_of(::getuid())})), "");
  const std::string wrong = name_in(address_) + address.substr(5);
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_with({to_program(wrong)})), "");
  publish("go");
  EXPECT_FALSE(is_readable());
}

/// Every local user may subscribe. What one does not read is kept in the room of a socket of the
/// publisher.
TEST_F(EventsInC, WhoDoesNotReadTakesNothingFromOthers) {
  const Events deaf{mlcca_events_new()};
  ASSERT_EQ(
      use(publisher_, 7, MLCCA_PUBLISHER,
          reply_with({to_program(mlcca_events_address(deaf.get(), 3)), to_program(address_)})),
      "");
  ASSERT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER, reply_with({from_programs_of(::getuid())})), "");
  const std::string event(30'000, 'a');
  for (int i = 0; i < 40; ++i) {
    EXPECT_NE(publish(event), MLCCA_LOST) << i;
    EXPECT_EQ(came().size(), 1U) << i;
  }
  EXPECT_EQ(publish(event), MLCCA_PARTLY);
}

/// There may be more of them than a program has descriptors to spare.
TEST_F(EventsInC, ManyReceiversTakeABoundedNumberOfSockets) {
  const auto descriptors = [] {
    const std::filesystem::directory_iterator all("/proc/self/fd");
    return std::distance(begin(all), end(all));
  };
  std::vector<LocalReceiver> receivers;
  std::vector<control::Endpoint> endpoints;
  for (int i = 0; i < 300; ++i) {
    auto receiver = LocalReceiver::open();
    ASSERT_TRUE(receiver) << receiver.error().text;
    endpoints.push_back(to_program(receiver->address()));
    receivers.push_back(std::move(*receiver));
  }
  const auto before = descriptors();
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_with(endpoints)), "");
  EXPECT_EQ(publish("go"), MLCCA_SENT);
  EXPECT_EQ(publish("go"), MLCCA_SENT);
  EXPECT_LE(descriptors(), before + 256);
  std::vector<std::uint8_t> buffer(LocalReceiver::kBuffer);
  for (LocalReceiver& receiver : receivers)
    EXPECT_EQ(receiver.receive(10, buffer, [](const LocalEvent&) {}), 2U);
  // Those that are not stated any more are closed, and those that are gone.
  endpoints.resize(3);
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_with(endpoints)), "");
  EXPECT_LE(descriptors(), before + 3);
  receivers.clear();
  EXPECT_EQ(publish("go"), MLCCA_NOT_GRANTED) << "nobody is there";
  EXPECT_EQ(descriptors(), before - 300);
}

/// Any user can announce an address that no socket has.
TEST_F(EventsInC, AReceiverThatIsGoneIsNoLoss) {
  std::string nobody;
  {
    const Events gone{mlcca_events_new()};
    nobody = mlcca_events_address(gone.get(), 3);
  }
  const auto both = reply_with({to_program(nobody), to_program(address_)});
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, both), "");
  ASSERT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER, reply_with({from_programs_of(::getuid())})), "");
  EXPECT_EQ(publish("1"), MLCCA_SENT);
  EXPECT_EQ(publish("2"), MLCCA_SENT);
  EXPECT_EQ(came(), (std::vector<std::string>{"3 1", "3 2"}));
}

/// A socket that receives no datagrams has the name.
TEST_F(EventsInC, AReceiverThatIsNoneIsNoLoss) {
  const Fd stream(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_un own{};
  own.sun_family = AF_UNIX;
  ASSERT_EQ(::bind(stream.get(), generic(own), sizeof own.sun_family), 0);
  socklen_t size = sizeof own;
  ASSERT_EQ(::getsockname(stream.get(), reinterpret_cast<sockaddr*>(&own), &size), 0);
  const std::string name(&own.sun_path[1], 5);
  ASSERT_EQ(
      use(publisher_, 7, MLCCA_PUBLISHER, reply_with({to_program(name + address_.substr(5))})), "");
  EXPECT_EQ(publish("1"), MLCCA_NOT_GRANTED);
}

/// It is not looked for with each event, but when the daemon states it again, and later.
TEST(LocalSendersTest, AReceiverThatIsGoneIsLookedForAgain) {
  const std::string address = LocalReceiver::open().value().address();
  const Fd epoll(::epoll_create1(EPOLL_CLOEXEC));
  LocalSenders senders(epoll);
  const auto to = to_program(address);
  EXPECT_EQ(senders.send(to, kStop, {}), LocalSender::Sent::gone);
  // Somebody has the name now.
  const Fd other(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_un own{};
  own.sun_family = AF_UNIX;
  name_in(address).copy(&own.sun_path[1], 5);
  ASSERT_EQ(::bind(other.get(), generic(own), offsetof(sockaddr_un, sun_path) + 6), 0);
  EXPECT_EQ(senders.send(to, kStop, {}), LocalSender::Sent::gone) << "it is not tried";
  senders.keep_only({LocalSenders::receiver_of(to)});
  EXPECT_EQ(senders.send(to, kStop, {}), LocalSender::Sent::sent);
}

/// A daemon gives none of these.
TEST_F(EventsInC, WhatIsNoAddressIsNotSentTo) {
  ASSERT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER, reply_with({from_programs_of(::getuid())})), "");
  std::string capital = address_;
  capital[0] = 'A';
  for (const std::string& wrong :
       {name_in(address_), address_ + "0", address_.substr(0, 20), capital,
        name_in(address_) + "0123456789abcdeg", std::string(21, '\0'), std::string(200, 'a')}) {
    ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_with({to_program(wrong)})), "");
    EXPECT_EQ(publish("go"), MLCCA_LOST) << wrong;
  }
  EXPECT_FALSE(is_readable());
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

/// It may be read long after that.
TEST_F(EventsInC, TheTimeOfAnEventIsWhenTheKernelReceivedIt) {
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_with({to_program(address_)})), "");
  ASSERT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER, reply_with({from_programs_of(::getuid())})), "");
  const std::uint64_t before = unix_ns();
  ASSERT_EQ(publish("go"), MLCCA_SENT);
  const std::uint64_t after = unix_ns();
  Came came;
  mlcca_events_process(subscriber_.get(), Came::take, &came);
  ASSERT_EQ(came.times.size(), 1U);
  EXPECT_GE(came.times[0], before);
  EXPECT_LE(came.times[0], after);
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

/// As a peer sends it to a network of FAMOUSO on the loopback.
void send_as_a_peer(std::uint16_t port, const std::string& event) {
  const int sender = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_addr.s_addr = htonl(INADDR_LOOPBACK + 1);
  sockaddr_in to = own;
  to.sin_port = htons(port);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(::bind(sender, reinterpret_cast<sockaddr*>(&own), sizeof own), 0);
  const std::string all = std::string("stop\0\0\0\0\0", 9) + event;
  ASSERT_EQ(
      ::sendto(sender, all.data(), all.size(), 0, reinterpret_cast<sockaddr*>(&to), sizeof to),
      static_cast<ssize_t>(all.size()));
  ::close(sender);
}

/// After a reload the network on an interface may be one of another kind.
TEST_F(EventsInC, AnInterfaceIsOpenedAgainWhereItsNetworkHasAnotherForm) {
  constexpr std::uint16_t multicast = 9999;
  constexpr std::uint16_t broadcast = 8888;
  control::Endpoint field;
  field.interface = "lo";
  field.ifindex = ::if_nametoindex("lo");
  const std::string before = reply_with({field});
  field.broadcast = true;
  const std::string after = reply_with({field});
  for (const std::uint64_t end : {1, 2})
    ASSERT_EQ(use(subscriber_, end, MLCCA_SUBSCRIBER, before), "");
  send_as_a_peer(multicast, "a");
  EXPECT_EQ(came(), (std::vector<std::string>{"1 a", "2 a"}));
  ASSERT_EQ(use(subscriber_, 1, MLCCA_SUBSCRIBER, after), "");
  send_as_a_peer(broadcast, "b");
  EXPECT_EQ(came(), std::vector<std::string>{"1 b"}) << "the other one is answered later";
  ASSERT_EQ(use(subscriber_, 2, MLCCA_SUBSCRIBER, after), "");
  send_as_a_peer(multicast, "c");
  send_as_a_peer(broadcast, "d");
  EXPECT_EQ(came(), (std::vector<std::string>{"1 d", "2 d"}));
  ASSERT_EQ(use(subscriber_, 1, MLCCA_SUBSCRIBER, before), "");
  ASSERT_EQ(use(subscriber_, 2, MLCCA_SUBSCRIBER, before), "");
  send_as_a_peer(multicast, "e");
  EXPECT_EQ(came(), (std::vector<std::string>{"1 e", "2 e"}));
}

TEST_F(EventsInC, AnEndpointThatCannotBeUsedIsTriedAgain) {
  control::Endpoint nowhere;
  nowhere.network = "field";
  nowhere.interface = "none0";
  nowhere.ifindex = 999'999;
  const std::string reply = reply_with({nowhere});
  for (int i = 0; i < 2; ++i) EXPECT_NE(use(subscriber_, 3, MLCCA_SUBSCRIBER, reply), "") << i;
}

/// Each event comes once to a subscriber, however many users may send it.
TEST_F(EventsInC, WhereTwoUsersPublishAnEventComesOnce) {
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_with({to_program(address_)})), "");
  ASSERT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER,
                reply_with({from_programs_of(::getuid()), from_programs_of(::getuid() + 1)})),
            "");
  EXPECT_EQ(publish("go"), MLCCA_SENT);
  EXPECT_EQ(came(), std::vector<std::string>{"3 go"});
}

TEST_F(EventsInC, WhatIsLongerThanTheChannelHasIsNeitherSentNorReceived) {
  control::Endpoint short_one = to_program(address_);
  short_one.frame_bytes = 8;
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_with({short_one})), "");
  EXPECT_EQ(publish("123456789"), MLCCA_TOO_LONG);
  ASSERT_EQ(use(publisher_, 7, MLCCA_PUBLISHER, reply_with({to_program(address_)})), "");
  control::Endpoint from = from_programs_of(::getuid());
  from.frame_bytes = 8;
  ASSERT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER, reply_with({from})), "");
  EXPECT_EQ(publish("123456789"), MLCCA_SENT) << "by a library that does not check";
  EXPECT_EQ(publish("12345678"), MLCCA_SENT);
  EXPECT_EQ(came(), std::vector<std::string>{"3 12345678"});
  EXPECT_EQ(mlcca_events_lost(subscriber_.get()), 1U);
}

TEST_F(EventsInC, ASilenceIsGivenAsAReply) {
  control::Endpoint from = from_programs_of(::getuid());
  from.silence_ns = 1'000'000;
  ASSERT_EQ(use(subscriber_, 3, MLCCA_SUBSCRIBER, reply_with({from})), "");
  std::uint64_t end = 0;
  std::string reply(4096, '?');
  std::size_t size = 0;
  while (size == 0) {
    pollfd waits{.fd = mlcca_events_fd(subscriber_.get()), .events = POLLIN, .revents = 0};
    ASSERT_EQ(::poll(&waits, 1, 60'000), 1);
    EXPECT_TRUE(came().empty());
    size = mlcca_events_happened(subscriber_.get(), &end, reply.data(), 3);
  }
  EXPECT_GT(size, 3U) << "there is no room";
  EXPECT_EQ(mlcca_events_happened(subscriber_.get(), &end, reply.data(), reply.size()), size);
  EXPECT_EQ(end, 3U);
  control::Buffer buffer;
  buffer.append(std::string_view(reply).substr(0, size));
  const auto decoded = control::decode_reply(buffer);
  ASSERT_TRUE(decoded && *decoded);
  EXPECT_EQ(std::get<control::Event>((*decoded)->body).kind, "missing");
  EXPECT_EQ(mlcca_events_happened(subscriber_.get(), &end, reply.data(), reply.size()), 0U);
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
