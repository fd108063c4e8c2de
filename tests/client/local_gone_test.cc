// SPDX-License-Identifier: BSD-2-Clause
// Events between programs on the gateway pass no gate. When the gates close, because the daemon
// stops or is gone for longer than its grace, the library ends them.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "client/local_socket.hpp"
#include "tests/client/scene.hpp"

namespace mlcca::client {
namespace {

using Texts = std::vector<std::string>;

/// What is granted between programs of this user, for the grace (ns).
control::Reply granted_here(std::uint64_t grace, const std::string& to = {}) {
  control::Endpoint endpoint;
  endpoint.local = to;
  if (to.empty()) endpoint.user = ::getuid();
  control::Channels out{{delivery("bridge", true)}, 0, {endpoint}};
  out.grace_ns = grace;
  return {0, std::move(out)};
}

constexpr std::uint64_t kGrace = 100'000'000;
constexpr std::uint64_t kHour = 3'600'000'000'000;

/// A program that subscribes, and another one's socket that sends to it.
class LocalGone : public ::testing::Test {
 protected:
  void start(std::deque<Server::Answer> answers, milliseconds answers_within = kLong,
             milliseconds retry = milliseconds(1)) {
    scene_.emplace(std::move(answers));
    Options options = scene_->options();
    std::filesystem::create_symlink(options.socket, path_);
    options.socket = path_;
    options.answers_within = answers_within;
    options.first_retry = options.longest_retry = retry;
    client_.emplace(options);
    subscriber_.emplace(*client_, "stop");
    subscriber_->on_event([this](const Event& e) { came_.emplace_back(e.data, e.data + e.size); });
    ASSERT_EQ(subscriber_->subscribe()->state, State::granted);
    const auto requests = scene_->requests();
    const auto& announced = std::get<control::AnnounceRequest>(requests.at(0).body);
    sender_.emplace(LocalSender::open(control::local_address_in(announced.local).value()).value());
  }
  void send(const std::string& text) {
    const std::vector<std::uint8_t> octets(text.begin(), text.end());
    ASSERT_EQ(sender_->send(kSubject, octets), LocalSender::Sent::sent);
    client_->process();
  }
  /// Announces another channel, behind whose answer the connection is lost.
  void lose() { static_cast<void>(SubscriberChannel(*client_, "other").subscribe()); }
  /// The same, and no daemon can be reached any more.
  void lose_for_good() {
    std::filesystem::remove(path_);
    lose();
  }
  Texts next(std::size_t count) { return causes(exceptions(*client_, *subscriber_, count)); }

  test::TempDir directory_;
  std::string path_ = directory_.path("control.sock");
  std::optional<Scene> scene_;
  std::optional<Client> client_;
  std::optional<SubscriberChannel> subscriber_;
  std::optional<LocalSender> sender_;
  Texts came_;
};

TEST_F(LocalGone, ADaemonThatIsLostForLongerThanItsGraceIsToldAndNothingIsDelivered) {
  start({{{granted_here(kGrace)}}, {{channels({})}, true}});
  send("1");
  lose_for_good();
  EXPECT_EQ(next(2), (Texts{"daemon-gone", "gates-closed"}));
  send("2");
  EXPECT_EQ(came_, Texts{"1"});
  EXPECT_EQ(subscriber_->lost(), 1U);
  EXPECT_EQ(client_->lost(), 1U);
}

TEST_F(LocalGone, WithinTheGraceTheyAreDelivered) {
  start({{{granted_here(kHour)}}, {{channels({})}, true}});
  lose_for_good();
  EXPECT_EQ(next(1), Texts{"daemon-gone"});
  send("1");
  EXPECT_EQ(came_, Texts{"1"});
}

TEST_F(LocalGone, ADaemonThatHangsForLongerThanItsGraceIsToldAndIsBackWhenItAnswers) {
  start({{{granted_here(kGrace)}}}, milliseconds(50));
  scene_->hang(true);
  EXPECT_EQ(next(2), (Texts{"daemon-gone", "gates-closed"}));
  send("1");
  EXPECT_EQ(came_, Texts{});
  scene_->hang(false);
  Texts back = next(1);
  while (back.back() != "daemon-back") back = next(1);  // the loss is reported as well
  send("2");
  EXPECT_EQ(came_, Texts{"2"});
  EXPECT_EQ(subscriber_->lost(), 1U);
}

TEST_F(LocalGone, ADaemonThatStopsEndsThemAtOnce) {
  start({{{granted_here(kHour), event("stopped", 0)}}});
  EXPECT_EQ(next(1), Texts{"gates-closed"});
  send("1");
  EXPECT_EQ(came_, Texts{});
  EXPECT_EQ(subscriber_->lost(), 1U);
}

TEST_F(LocalGone, WhatADaemonAnswersThatStopsOpensNothing) {
  start({{{granted_here(kHour), event("stopped", 0), event("granted")}},
         {{granted_here(kHour), event("mode", 0)}}});
  EXPECT_EQ(next(2), (Texts{"gates-closed", "mode"}));
  send("1");
  EXPECT_EQ(came_, Texts{});
}

TEST_F(LocalGone, ADaemonThatHasRestartedOpensThemAgain) {
  start({{{granted_here(kHour)}},
         {{channels({}), event("stopped", 0)}, true},
         {{granted_here(kHour)}}});
  lose();
  EXPECT_EQ(next(3), (Texts{"gates-closed", "daemon-gone", "daemon-back"}));
  send("1");
  EXPECT_EQ(came_, Texts{"1"});
}

/// It cannot answer what is asked after that.
TEST_F(LocalGone, WhatIsWithdrawnEndsBeforeTheDaemonAnswers) {
  control::Reply withdrawn = event("withdrawn");
  std::get<control::Event>(withdrawn.body).network = "bridge";
  std::get<control::Event>(withdrawn.body).publisher = "lever";
  const control::Reply busy{
      0, control::Error{.kind = control::ErrorKind::world, .message = "no memory"}};
  start({{{granted_here(kHour)}}, {{channels({}), withdrawn}}, {{busy}}}, kLong, kLong);
  static_cast<void>(SubscriberChannel(*client_, "other").subscribe());
  EXPECT_EQ(next(1), Texts{"withdrawn"});
  send("1");
  EXPECT_EQ(came_, Texts{});
  EXPECT_EQ(subscriber_->lost(), 1U);
}

TEST_F(LocalGone, APublisherSendsNothingEither) {
  start({{{granted_here(kHour)}}});
  const auto requests = scene_->requests();
  const auto& announced = std::get<control::AnnounceRequest>(requests.at(0).body);
  Scene scene({{{granted_here(kHour, announced.local), event("stopped", 0)}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  ASSERT_EQ(stop.announce()->state, State::granted);
  EXPECT_EQ(causes(exceptions(client, stop, 1)), Texts{"gates-closed"});
  EXPECT_EQ(stop.publish("1"), Published::lost);
  client_->process();
  EXPECT_EQ(came_, Texts{});
  EXPECT_EQ(subscriber_->lost(), 1U);
}

}  // namespace
}  // namespace mlcca::client
