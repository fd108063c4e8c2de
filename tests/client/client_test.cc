// SPDX-License-Identifier: BSD-2-Clause
// A program against a daemon that answers what a test wants.
#include "mlcca/client/client.hpp"

#include <gtest/gtest.h>
#include <poll.h>

#include <atomic>
#include <chrono>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/client/scene.hpp"

namespace mlcca::client {
namespace {

TEST(Client, AnAnnouncementGetsWhatIsDecidedWithItsReasons) {
  Scene scene({{{channels({delivery("robot-can", true)})}}});
  Client client(scene.options());
  PublisherChannel stop(
      client, "stop", AttributeSet{}.set(Attribute::period, 50'000'000).set(Attribute::omission, 2),
      "lever");
  EXPECT_EQ(stop.answer()->state, State::unannounced);
  const auto answer = stop.announce();
  EXPECT_EQ(answer->state, State::granted);
  EXPECT_EQ(answer->reason, "1 to spare");
  ASSERT_EQ(answer->deliveries.size(), 1U);
  EXPECT_EQ(answer->deliveries[0].to, "robot-can");
  ASSERT_EQ(answer->deliveries[0].checks.size(), 1U);
  EXPECT_EQ(answer->deliveries[0].checks[0].provided, 1U);
  EXPECT_TRUE(answer->deliveries[0].checks[0].fits);
  ASSERT_EQ(scene.requests().size(), 1U);
  EXPECT_EQ(scene.requests()[0].body,
            (decltype(control::Request::body)(control::AnnounceRequest{
                "stop",
                control::Role::publisher,
                "lever",
                {{.name = "Period", .value = 50'000'000, .unit = "ns", .dynamic = false},
                 {.name = "Omission", .value = 2, .unit = "events", .dynamic = false}}})));
}

TEST(Client, ASubscriberIsOne) {
  Scene scene({{{channels({delivery("bridge", true)})}}});
  Client client(scene.options());
  SubscriberChannel stop(client, "0xa4efeccc3210b497");
  EXPECT_EQ(stop.subscribe()->state, State::granted);
  const auto request = std::get<control::AnnounceRequest>(scene.requests()[0].body);
  EXPECT_EQ(request.role, control::Role::subscriber);
  EXPECT_EQ(request.channel, "0xa4efeccc3210b497");
}

TEST(Client, WhatIsRefusedGivesTheReason) {
  Scene scene({{{channels({delivery("robot-can", false), delivery("second-can", true)})}},
               {{channels({delivery("robot-can", false)})}},
               {{channels({})}},
               {{{0, control::Error{control::ErrorKind::forbidden, "lever is not for you", {}}}}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  EXPECT_EQ(stop.announce()->state, State::partly);
  EXPECT_EQ(stop.answer()->reason, "Omission 2 required, bridge provides 5 (3 too many)");
  EXPECT_EQ(stop.announce()->state, State::refused);
  EXPECT_EQ(stop.announce()->state, State::refused);
  EXPECT_EQ(stop.answer()->reason, "nobody is at the other end");
  EXPECT_EQ(stop.announce()->state, State::rejected);
  EXPECT_EQ(stop.answer()->reason, "lever is not for you");
}

TEST(Client, WithoutADaemonItIsSaidAtOnceAndAnnouncedOnceThereIsOne) {
  const test::TempDir folder;
  Scene scene({{{channels({delivery("robot-can", true)})}}});
  Options options = scene.options();
  options.socket = folder.path("later.sock");
  Client client(options);
  PublisherChannel stop(client, "stop");
  EXPECT_EQ(stop.announce()->state, State::no_daemon);
  EXPECT_EQ(stop.answer()->reason, "no daemon: " + options.socket + ": No such file or directory");
  EXPECT_FALSE(client.is_connected());
  std::filesystem::create_symlink(scene.options().socket, options.socket);
  const auto all = exceptions(client, stop, 1);
  EXPECT_EQ(causes(all), std::vector<std::string>{"daemon-back"});
  EXPECT_EQ(all[0].answer->state, State::granted);
  EXPECT_EQ(stop.answer()->state, State::granted);
}

TEST(Client, ADaemonThatIsLostIsReportedAndEveryChannelIsAnnouncedAgain) {
  Scene scene({{{channels({delivery("robot-can", true)})}},
               {{channels({delivery("second-can", true)})}, true},
               {{channels({delivery("robot-can", false)})}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  SubscriberChannel other(client, "other");
  ASSERT_EQ(stop.announce()->state, State::granted);
  other.subscribe();  // behind whose answer it is lost
  const auto all = exceptions(client, stop, 2);
  EXPECT_EQ(causes(all), (std::vector<std::string>{"daemon-gone", "daemon-back"}));
  EXPECT_EQ(all[0].answer->state, State::no_daemon);
  EXPECT_EQ(all[0].text, "mlccad closed the connection");
  EXPECT_EQ(all[1].answer->state, State::refused);
  while (other.answer()->state == State::no_daemon) client.wait(kLong);
  EXPECT_EQ(scene.requests().size(), 4U);
}

TEST(Client, AVerdictThatChangesIsAskedForAndGivenWithTheException) {
  // Right behind the first answer the event might be read with it, and announce() wait for the
  // next.
  Scene scene({{{channels({delivery("robot-can", true)})}},
               {{channels({}), event("withdrawn")}},
               {{channels({delivery("robot-can", false)}), event("granted")}},
               {{channels({delivery("robot-can", true)})}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  ASSERT_EQ(stop.announce()->state, State::granted);
  SubscriberChannel other(client, "other");
  other.subscribe();  // behind whose answer it is withdrawn
  const auto all = exceptions(client, stop, 2);
  EXPECT_EQ(causes(all), (std::vector<std::string>{"withdrawn", "granted"}));
  EXPECT_EQ(all[0].text, "what is withdrawn");
  EXPECT_EQ(all[0].answer->state, State::refused);
  EXPECT_EQ(all[1].answer->state, State::granted);
}

TEST(Client, ChangesOfOtherEndsAreNone) {
  Scene scene({{{channels({delivery("robot-can", true)}), event("refused")}},
               {{channels({delivery("robot-can", true)}), event("missing")}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  ASSERT_EQ(stop.announce()->state, State::granted);
  EXPECT_EQ(causes(exceptions(client, stop, 1)), std::vector<std::string>{"missing"});
}

/// Before there is a delivery the daemon has told no subject.
TEST(Client, TheFirstDeliveryOfAChannelIsReported) {
  Scene scene({{{channels({}), event("granted")}}, {{channels({delivery("robot-can", true)})}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  stop.announce();
  EXPECT_EQ(causes(exceptions(client, stop, 1)), std::vector<std::string>{"granted"});
}

TEST(Client, AnotherAttributeSetIsDegradedOrUpgraded) {
  Scene scene({{{channels({delivery("robot-can", true, 0)}), event("degraded")}},
               {{channels({delivery("robot-can", true, 2)}), event("upgraded")}},
               {{channels({delivery("robot-can", true, 1)})}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  stop.announce();
  const auto all = exceptions(client, stop, 2);
  EXPECT_EQ(causes(all), (std::vector<std::string>{"degraded", "upgraded"}));
  EXPECT_EQ(all[0].answer->deliveries[0].set, 2U);
  EXPECT_EQ(all[1].answer->deliveries[0].set, 1U);
}

TEST(Client, WhatHappensToEventsIsGivenWithItsNumbers) {
  control::Reply missing = event("missing");
  std::get<control::Event>(missing.body).silent_ns = 161'000'000;
  std::get<control::Event>(missing.body).missing = 3;
  control::Reply excess = event("policed");
  std::get<control::Event>(excess.body).frames = 12;
  control::Reply dropping = event("dropped");
  std::get<control::Event>(dropping.body).frames = 34;
  control::Reply late = event("late");
  std::get<control::Event>(late.body).late = 5;
  std::get<control::Event>(late.body).longest_ns = 7'000'000;
  Scene scene({{{channels({delivery("bridge", true)}), missing, event("restored"), excess, dropping,
                 late, event("lapsed", 0), event("mode", 0), event("invented")}}});
  Client client(scene.options());
  SubscriberChannel stop(client, "stop");
  stop.subscribe();
  const auto all = exceptions(client, stop, 8);
  EXPECT_EQ(causes(all), (std::vector<std::string>{"missing", "restored", "policed", "dropped",
                                                   "late", "gates-closed", "mode", "other"}));
  EXPECT_EQ(all[0].silent, milliseconds(161));
  EXPECT_EQ(all[0].missing_events, 3U);
  EXPECT_EQ(all[2].frames, 12U);
  EXPECT_EQ(all[3].frames, 34U);
  EXPECT_EQ(all[4].late_events, 5U);
  EXPECT_EQ(all[4].longest, milliseconds(7));
  EXPECT_EQ(all[7].text, "what is invented");
}

bool readable(const Client& client) {
  pollfd waits{.fd = client.fd(), .events = POLLIN, .revents = 0};
  return ::poll(&waits, 1, 0) > 0;
}

/// For programs that have a loop of their own.
TEST(Client, ItsDescriptorCanBeReadWhileThereIsSomethingToDo) {
  Scene scene({{{channels({delivery("robot-can", true)})}},
               {{event("missing"), channels({delivery("robot-can", true)})}}});
  Client client(scene.options());
  EXPECT_FALSE(readable(client));
  PublisherChannel stop(client, "stop");
  stop.announce();
  EXPECT_FALSE(readable(client));
  stop.announce();
  EXPECT_TRUE(readable(client)) << "an exception came while it waited for the answer";
  client.process();
  EXPECT_FALSE(readable(client));
}

TEST(Client, AHandlerMayEndTheChannelAndThrow) {
  Scene scene({{{channels({delivery("robot-can", true)}), event("missing"), event("restored")}}});
  Client client(scene.options());
  auto stop = std::make_unique<PublisherChannel>(client, "stop");
  PublisherChannel same(client, "stop");
  int called = 0;
  stop->on_exception([&](const Exception&) {
    ++called;
    stop.reset();
    throw std::runtime_error("of the handler");
  });
  stop->announce();
  EXPECT_THROW(for (;;) client.wait(kLong), std::runtime_error);
  EXPECT_EQ(called, 1);
  EXPECT_EQ(same.announce()->state, State::granted);
  EXPECT_EQ(exceptions(client, same, 2).front().answer->state, State::granted);
  EXPECT_EQ(called, 1);
}

TEST(Client, ADaemonThatDoesNotAnswerInTimeIsNone) {
  const test::TempDir folder;
  const Fd silent = test::listen_at(folder.path("s"));
  Client client({.socket = folder.path("s"),
                 .patience = milliseconds(5),
                 .first_retry = milliseconds(1),
                 .longest_retry = milliseconds(1)});
  PublisherChannel stop(client, "stop");
  EXPECT_EQ(stop.announce()->state, State::no_daemon);
  EXPECT_EQ(stop.answer()->reason, "no answer from mlccad within 5 ms");
}

TEST(Client, AChannelMayOutliveItsClient) {
  Scene scene({{{channels({delivery("robot-can", true)})}}});
  auto client = std::make_unique<Client>(scene.options());
  PublisherChannel stop(*client, "stop");
  ASSERT_EQ(stop.announce()->state, State::granted);
  client.reset();
  EXPECT_EQ(stop.announce()->state, State::granted) << "nothing happens to it any more";
}

TEST(Client, APathThatIsTooLongIsSaid) {
  Client client({.socket = std::string(200, 'x')});
  PublisherChannel stop(client, "stop");
  EXPECT_EQ(stop.announce()->state, State::no_daemon);
  EXPECT_NE(stop.answer()->reason.find("must have 1 to 107 bytes"), std::string::npos);
}

}  // namespace
}  // namespace mlcca::client
