// SPDX-License-Identifier: BSD-2-Clause
// Events between programs on a gateway are held against what is granted, as a gate does it.
#include "client/local_source.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <stdexcept>
#include <string>
#include <vector>

#include "client/local_socket.hpp"
#include "tests/client/scene.hpp"

namespace mlcca::client {
namespace {

constexpr std::uint64_t kMilli = 1'000'000;
constexpr std::uint64_t kBegin = 1'000'000 * kMilli;
constexpr std::uint64_t kUnix = 1'700'000'000'000 * kMilli;

control::Endpoint granted() {
  control::Endpoint out;
  out.user = ::getuid();
  out.publisher = "lever";
  out.frame_bytes = 8;
  out.period_ns = 50 * kMilli;
  out.silence_ns = 150 * kMilli;
  return out;
}

struct LocalSourceTest : ::testing::Test {
  LocalSource source_{granted(), kBegin};
  bool takes(std::uint64_t at_ms, std::size_t bytes = 2) {
    return source_.takes(bytes, kUnix + at_ms * kMilli, kBegin + at_ms * kMilli);
  }
  std::string happened(std::uint64_t at_ms) {
    const auto event = source_.happened(kBegin + at_ms * kMilli);
    if (!event) return "";
    EXPECT_EQ(event->publisher, "lever");
    return event->kind + ": " + event->message;
  }
  std::uint64_t due_ms() const { return (source_.due().value_or(kBegin) - kBegin) / kMilli; }
};

TEST_F(LocalSourceTest, ASilenceIsReportedOnceAndThatItIsOverWhenEventsHaveComeForAWhile) {
  EXPECT_EQ(due_ms(), 150U);
  EXPECT_TRUE(takes(50));
  EXPECT_EQ(happened(150), "") << "as long as that after the last one";
  EXPECT_EQ(due_ms(), 200U);
  EXPECT_EQ(happened(211),
            "missing: nothing has come from programs on this gateway for 161 ms: 3 "
            "events are missing");
  EXPECT_EQ(happened(400), "") << "once";
  EXPECT_FALSE(source_.due()) << "nothing to wait for but an event";
  EXPECT_TRUE(takes(500));
  EXPECT_EQ(due_ms(), 1500U);
  EXPECT_EQ(happened(1500), "") << "with a break: nothing since then";
  EXPECT_FALSE(source_.due());
  for (std::uint64_t at = 2000; at <= 3000; at += 100) EXPECT_TRUE(takes(at));
  EXPECT_EQ(happened(2999), "");
  EXPECT_EQ(happened(3000),
            "restored: events of programs on this gateway come again: for 1950 ms "
            "they stayed out, or came with breaks");
  EXPECT_EQ(due_ms(), 3150U);
}

TEST_F(LocalSourceTest, WithoutAnOmissionNothingIsSupervised) {
  control::Endpoint plain = granted();
  plain.silence_ns = 0;
  source_.grant(plain);
  EXPECT_FALSE(source_.due());
  EXPECT_EQ(happened(10'000), "");
}

TEST_F(LocalSourceTest, WhatIsLongerThanTheChannelHasIsDropped) {
  EXPECT_TRUE(takes(1, 8));
  EXPECT_FALSE(takes(2, 9));
  EXPECT_TRUE(takes(3, 0));
  control::Endpoint of_older_daemon = granted();
  of_older_daemon.frame_bytes = 0;
  source_.grant(of_older_daemon);
  EXPECT_TRUE(takes(4, 65'535));
}

TEST_F(LocalSourceTest, WhatIsMoreThanIsAdmittedIsDroppedAndReportedOnceASecond) {
  control::Endpoint policed = granted();
  policed.silence_ns = 0;
  policed.event_cost_ns = policed.tolerance_ns = 50 * kMilli;
  source_.grant(policed);
  unsigned taken = 0;
  for (std::uint64_t at = 0; at < 1000; at += 10) taken += takes(at) ? 1 : 0;
  EXPECT_EQ(taken, 21U) << "one early, and one each 50 ms";
  EXPECT_EQ(due_ms(), 1020U) << "a second after the first one that was too much";
  EXPECT_EQ(happened(1019), "");
  EXPECT_EQ(happened(1020),
            "policed: 79 events are dropped of programs on this gateway: more than is admitted");
  EXPECT_FALSE(source_.due());
  // The clock of the system is set back.
  EXPECT_TRUE(source_.takes(2, kUnix - 3'600'000 * kMilli, kBegin + 2000 * kMilli));
}

TEST_F(LocalSourceTest, WhatWasMissedIsReportedTogether) {
  control::Endpoint plain = granted();
  plain.silence_ns = 0;
  source_.grant(plain);
  source_.miss(0, kBegin);
  EXPECT_FALSE(source_.due());
  source_.miss(2, kBegin + 10 * kMilli);
  source_.miss(3, kBegin + 500 * kMilli);
  EXPECT_EQ(due_ms(), 1010U);
  EXPECT_EQ(happened(1009), "");
  EXPECT_EQ(happened(1010),
            "missed: 5 events are lost of programs on this gateway: this program did not read "
            "them in time, or the gates were closed");
  EXPECT_FALSE(source_.due());
  EXPECT_EQ(happened(3000), "");
}

TEST_F(LocalSourceTest, BytesMayCostAsWell) {
  control::Endpoint policed = granted();
  policed.byte_cost = 256 * kMilli;  // 1 ms
  source_.grant(policed);
  EXPECT_TRUE(takes(0, 8));
  EXPECT_FALSE(takes(7, 8));
  EXPECT_TRUE(takes(8, 8));
}

/// A program that subscribes, and the address that it has announced.
struct LocalClient {
  explicit LocalClient(const control::Endpoint& endpoint)
      : scene({{{{0, control::Channels{{delivery("here", true)}, 0, {endpoint}}}}}}),
        client(scene.options()),
        subscriber(client, "stop") {
    subscriber.on_event([this](const Event& e) { came.emplace_back(e.data, e.data + e.size); });
    subscriber.subscribe();
    const auto requests = scene.requests();
    const auto& announced = std::get<control::AnnounceRequest>(requests.at(0).body);
    auto to = LocalSender::open(control::local_address_in(announced.local).value());
    if (!to) throw std::runtime_error(to.error().text);
    sender.emplace(std::move(*to));
  }
  void send(const std::string& text) {
    const std::vector<std::uint8_t> octets(text.begin(), text.end());
    ASSERT_EQ(sender->send(kSubject, octets), LocalSender::Sent::sent);
  }
  bool is_readable() const {
    pollfd waits{.fd = client.fd(), .events = POLLIN, .revents = 0};
    return ::poll(&waits, 1, 0) == 1;
  }
  Scene scene;
  Client client;
  SubscriberChannel subscriber;
  std::optional<LocalSender> sender;
  std::vector<std::string> came;
};

TEST(LocalEvents, ASilenceIsAnExceptionOfTheSubscriber) {
  LocalClient program(granted());
  program.send("go");
  const auto all = exceptions(program.client, program.subscriber, 1);
  EXPECT_EQ(causes(all), std::vector<std::string>{"missing"});
  EXPECT_EQ(all[0].publisher, "lever");
  EXPECT_GE(all[0].silent, std::chrono::milliseconds(150));
  EXPECT_GE(all[0].missing_events, 3U);
  EXPECT_EQ(program.came, std::vector<std::string>{"go"});
}

TEST(LocalEvents, WhatIsTooLongOrTooMuchIsCounted) {
  control::Endpoint policed = granted();
  policed.silence_ns = 0;
  policed.event_cost_ns = 3'600'000 * kMilli;
  LocalClient program(policed);
  program.send("123456789");
  program.send("go");
  program.send("no");
  const auto all = exceptions(program.client, program.subscriber, 1);
  EXPECT_EQ(causes(all), std::vector<std::string>{"policed"});
  EXPECT_EQ(all[0].frames, 1U);
  EXPECT_EQ(program.subscriber.lost(), 2U);
  EXPECT_EQ(program.client.lost(), 2U);
  EXPECT_EQ(SubscriberChannel(program.client, "other").lost(), 0U);
  EXPECT_EQ(program.came, std::vector<std::string>{"go"});
}

TEST(LocalEvents, WhatWasMissedIsAnException) {
  control::Endpoint plain = granted();
  plain.silence_ns = 0;
  LocalClient program(plain);
  unsigned sent = 0;
  const std::array<std::uint8_t, 1> event{'a'};
  while (program.sender->send(kSubject, event) == LocalSender::Sent::sent) ++sent;
  for (int i = 0; i < 2; ++i)
    EXPECT_NE(program.sender->send(kSubject, event), LocalSender::Sent::sent);
  program.client.process();
  EXPECT_EQ(program.sender->send_notice(), LocalSender::Sent::sent);
  const auto all = exceptions(program.client, program.subscriber, 1);
  EXPECT_EQ(causes(all), std::vector<std::string>{"missed"});
  EXPECT_EQ(all[0].missing_events, 3U);
  EXPECT_EQ(all[0].publisher, "lever");
  EXPECT_EQ(program.subscriber.lost(), 3U);
  EXPECT_EQ(program.came.size(), sent);
}

/// The daemon is given the other address, and gives it to those that are granted.
TEST(LocalEvents, WhoIsWithdrawnKeepsAKeyThatIsOfNoUse) {
  control::Endpoint plain = granted();
  plain.silence_ns = 0;
  control::Channel here = delivery("bridge", true);
  control::Channel refused = delivery("bridge", false);
  Scene scene({{{{0, control::Channels{{here}, 0, {plain}}}, event("withdrawn")}},
               {{{0, control::Channels{{refused}, 0, {}}}}}});
  Client client(scene.options());
  SubscriberChannel subscriber(client, "stop");
  subscriber.subscribe();
  while (scene.requests().size() < 3) client.wait(kLong);
  std::vector<std::string> announced;
  for (const control::Request& request : scene.requests())
    announced.push_back(std::get<control::AnnounceRequest>(request.body).local);
  EXPECT_EQ(announced[1], announced[0]);
  EXPECT_NE(announced[2], announced[0]);
  auto old = LocalSender::open(control::local_address_in(announced[0]).value());
  ASSERT_TRUE(old);
  client.process();
  const std::array<std::uint8_t, 1> event{'a'};
  EXPECT_EQ(old->send(kSubject, event), LocalSender::Sent::sent);
  unsigned came = 0;
  subscriber.on_event([&came](const Event&) { ++came; });
  client.process();
  EXPECT_EQ(came, 0U);
}

/// A loop that waits for the descriptor would not find what is left.
TEST(LocalEvents, AfterAHandlerThrewTheDescriptorCanBeReadAsLongAsEventsWait) {
  control::Endpoint plain = granted();
  plain.silence_ns = 0;
  LocalClient program(plain);
  program.subscriber.on_event([&](const Event& e) {
    program.came.emplace_back(e.data, e.data + e.size);
    if (program.came.size() < 3) throw std::runtime_error("as it happens");
  });
  for (const char* text : {"1", "2", "3"}) program.send(text);
  EXPECT_THROW(program.client.wait(kLong), std::runtime_error);
  EXPECT_TRUE(program.is_readable());
  EXPECT_THROW(program.client.process(), std::runtime_error);
  EXPECT_TRUE(program.is_readable());
  program.client.process();
  EXPECT_EQ(program.came, (std::vector<std::string>{"1", "2", "3"}));
  program.client.process();
  EXPECT_FALSE(program.is_readable());
}

}  // namespace
}  // namespace mlcca::client
