// SPDX-License-Identifier: BSD-2-Clause
// What must not get lost on the way from the daemon to the handler of a program, and what must not
// grow.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "mlcca/client/generated.hpp"
#include "tests/client/scene.hpp"

namespace mlcca::client {
namespace {

using Texts = std::vector<std::string>;

control::Reply of_publisher(control::Reply event, const std::string& name) {
  std::get<control::Event>(event.body).publisher = name;
  return event;
}
control::Reply error(control::ErrorKind kind, const std::string& text) {
  return {0, control::Error{kind, text, {}}};
}

TEST(Exceptions, ManyEventsAreOneRequestAndTheWithdrawalIsToldAtOnce) {
  std::vector<control::Reply> all{channels({delivery("robot-can", true)})};
  for (int i = 0; i < 500; ++i) all.push_back(event("withdrawn"));
  Scene scene({{all}, {{channels({delivery("robot-can", false)})}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  stop.announce();
  EXPECT_EQ(causes(exceptions(client, stop, 1)), Texts{"withdrawn"});
  EXPECT_EQ(stop.announce()->state, State::refused);
  EXPECT_LE(scene.requests().size(), 4U);
}

/// Frames were dropped in between.
TEST(Exceptions, AWithdrawalIsToldAlsoWhereTheNextAnswerIsGrantedAgain) {
  Scene scene({{{channels({delivery("robot-can", true)}), event("withdrawn"), event("granted")}},
               {{channels({delivery("robot-can", true)})}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  stop.announce();
  EXPECT_EQ(causes(exceptions(client, stop, 2)), (Texts{"withdrawn", "granted"}));
}

TEST(Exceptions, ANetworkThatIsDownIsToldAsSuchAndByItsName) {
  control::Reply down = event("withdrawn");
  std::get<control::Event>(down.body).network_down = "second-can";
  Scene scene({{{channels({delivery("robot-can", true)}), down}},
               {{channels({delivery("robot-can", false)}), event("granted")}},
               {{channels({delivery("robot-can", true)})}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  stop.announce();
  const auto all = exceptions(client, stop, 2);
  EXPECT_EQ(causes(all), (Texts{"network-down", "granted"}));
  EXPECT_EQ(all[0].network, "second-can");
  EXPECT_EQ(all[0].answer->state, State::refused);
  EXPECT_EQ(all[0].text, "what is withdrawn");
  EXPECT_EQ(all[1].network, "");
}

/// What was wrong is not there any more, and something else may be.
TEST(Exceptions, WhatWasMissingIsNotSaidAnyMoreOnceItIsRestored) {
  control::Channel troubled = delivery("robot-can", true);
  troubled.problems = {"nothing has come for 161 ms"};
  control::Channel late = delivery("robot-can", true);
  late.problems = {"the program that carries it is late"};
  Scene scene({{{channels({troubled}), event("restored")}}, {{channels({late})}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  stop.announce();
  const auto all = exceptions(client, stop, 1);
  EXPECT_EQ(all[0].answer->deliveries[0].problem, "");
  while (stop.answer()->deliveries[0].problem.empty()) client.wait(kLong);
  EXPECT_EQ(stop.answer()->deliveries[0].problem, "the program that carries it is late");
}

/// What `mlccactl generate` makes knows no network.
struct GeneratedSpec {
  enum class Why : std::uint8_t {
    refused,
    withdrawn,
    switched,
    violated,
    granted,
    restored,
    unknown,
    known
  };
  static void exception(Why why) {
    last = why;
    numbers = exception_of<GeneratedSpec>();
    missing = numbers == nullptr ? 0 : numbers->missing_events;
    if (throws) throw std::runtime_error("of the user");
  }
  static void notify(const std::uint8_t* /*data*/, std::size_t /*size*/) {
    network = event_of<GeneratedSpec>()->network;
  }
  static inline std::optional<Why> last;
  static inline const Exception* numbers = nullptr;
  static inline std::uint64_t missing = 0;
  static inline bool throws = false;
  static inline std::string network;
};

TEST(Exceptions, GeneratedHandlersCanReadTheNumbers) {
  Exception missing;
  missing.cause = Cause::missing;
  missing.missing_events = 84;
  detail::call_handler<GeneratedSpec>(missing);
  EXPECT_EQ(GeneratedSpec::numbers, &missing);
  EXPECT_EQ(GeneratedSpec::missing, 84U);
  EXPECT_EQ(exception_of<GeneratedSpec>(), nullptr) << "it is over";
  GeneratedSpec::throws = true;
  EXPECT_THROW(detail::call_handler<GeneratedSpec>(missing), std::runtime_error);
  GeneratedSpec::throws = false;
  EXPECT_EQ(exception_of<GeneratedSpec>(), nullptr);
  Event event;
  event.network = "field";
  detail::call_event_handler<GeneratedSpec>(event);
  EXPECT_EQ(GeneratedSpec::network, "field");
  EXPECT_EQ(event_of<GeneratedSpec>(), nullptr);
}

TEST(Exceptions, ANetworkThatIsDownIsAWithdrawalToGeneratedHandlers) {
  Exception down;
  down.cause = Cause::network_down;
  detail::call_handler<GeneratedSpec>(down);
  EXPECT_EQ(GeneratedSpec::last, GeneratedSpec::Why::withdrawn);
}

TEST(Exceptions, GeneratedHandlersAreCalledForWhatIsWellAgainToo) {
  using Why = GeneratedSpec::Why;
  const auto reason = [](Cause cause) {
    GeneratedSpec::last.reset();
    Exception exception;
    exception.cause = cause;
    detail::call_handler<GeneratedSpec>(exception);
    return GeneratedSpec::last;
  };
  EXPECT_EQ(reason(Cause::granted), Why::granted);
  EXPECT_EQ(reason(Cause::restored), Why::restored);
  EXPECT_EQ(reason(Cause::daemon_gone), Why::unknown);
  EXPECT_EQ(reason(Cause::daemon_back), Why::known);
  for (const Cause none : {Cause::mode, Cause::lagged, Cause::other})
    EXPECT_EQ(reason(none), std::nullopt);
}

/// The daemon would close the connection, again and again, and with it that of the other channels.
TEST(Exceptions, WhatIsNoRequestIsRejectedByItself) {
  Scene scene({{{channels({delivery("robot-can", true)})}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  ASSERT_EQ(stop.announce()->state, State::granted);
  PublisherChannel longest(client, std::string(70'000, 'a'));
  EXPECT_EQ(longest.announce()->state, State::rejected);
  EXPECT_EQ(longest.answer()->reason,
            "the names and attributes are longer than a request may be, 65,536 bytes");
  SubscriberChannel unreadable(client, "stop", {}, "\xff");
  EXPECT_EQ(unreadable.subscribe()->state, State::rejected);
  EXPECT_EQ(unreadable.answer()->reason, "the names are not UTF-8");
  client.process();
  EXPECT_TRUE(client.is_connected());
  EXPECT_EQ(stop.announce()->state, State::granted);
  EXPECT_EQ(scene.requests().size(), 2U);
}

TEST(Exceptions, AnAnswerFromBeforeAChangeGrantsNothing) {
  Scene scene({{{channels({delivery("robot-can", true)}), event("withdrawn")}},
               {{event("withdrawn"), channels({delivery("robot-can", true)})}},
               {{channels({delivery("robot-can", false)})}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  stop.announce();
  EXPECT_EQ(causes(exceptions(client, stop, 1)), Texts{"withdrawn"});
  EXPECT_EQ(stop.announce()->state, State::refused);
  client.process();
  EXPECT_EQ(stop.answer()->state, State::refused);
}

/// Who does not call process() for long is told that it has missed something, and what counts.
TEST(Exceptions, ADaemonThatGoesIsToldHoweverMuchWaits) {
  std::vector<control::Reply> all{channels({delivery("robot-can", true)})};
  for (int i = 0; i < 3'000; ++i) all.push_back(event("missing"));
  Scene scene({{all, true}, {{channels({delivery("robot-can", true)})}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  PublisherChannel other(client, "other");
  Texts told;
  stop.on_exception([&](const Exception& e) { told.emplace_back(name_of(e.cause)); });
  stop.announce();
  while (stop.answer()->state != State::no_daemon) other.announce();  // no handler is called
  while (std::ranges::find(told, "daemon-back") == told.end()) client.wait(kLong);
  EXPECT_NE(std::ranges::find(told, "daemon-gone"), told.end());
  EXPECT_NE(std::ranges::find(told, "lagged"), told.end());
  EXPECT_LE(told.size(), 260U);
}

TEST(Exceptions, AReloadIsAskedForAndARejectionIsAnException) {
  Scene scene(
      {{{channels({delivery("robot-can", true)}), event("reload", 0)}},
       {{error(control::ErrorKind::invalid, "Period 50 ms is announced"), event("reload", 0)}},
       {{channels({delivery("robot-can", true)})}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  stop.announce();
  const auto all = exceptions(client, stop, 2);
  EXPECT_EQ(causes(all), (Texts{"rejected", "granted"}));
  EXPECT_EQ(all[0].answer->state, State::rejected);
  EXPECT_EQ(all[0].text, "Period 50 ms is announced");
}

TEST(Exceptions, AfterEventsThatWereLostOnTheWayItIsAskedAgain) {
  Scene scene({{{channels({delivery("robot-can", true)}), event("lagged", 0)}},
               {{channels({delivery("robot-can", false)})}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  stop.announce();
  EXPECT_EQ(causes(exceptions(client, stop, 1)), Texts{"withdrawn"});
}

TEST(Exceptions, OfAChannelThatIsAnnouncedByItsSubjectTheFirstDeliveryIsToldToo) {
  Scene scene({{{channels({}), event("granted")}}, {{channels({delivery("robot-can", true)})}}});
  Client client(scene.options());
  PublisherChannel stop(client, "0xa4efeccc3210b497");
  stop.announce();
  EXPECT_EQ(causes(exceptions(client, stop, 1)), Texts{"granted"});
}

TEST(Exceptions, WhatHappensToOthersIsNotTold) {
  Scene scene({{{channels({delivery("robot-can", true)}), of_publisher(event("missing"), "other"),
                 of_publisher(event("policed"), "other"), of_publisher(event("withdrawn"), "other"),
                 of_publisher(event("restored"), "lever")}},
               {{channels({delivery("robot-can", true)})}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  stop.announce();
  const auto all = exceptions(client, stop, 1);
  EXPECT_EQ(causes(all), Texts{"restored"});
  EXPECT_EQ(all[0].publisher, "lever");
}

/// A daemon that comes is found as soon as was promised, however often it was asked for in vain.
TEST(Exceptions, AnnouncingInVainPutsNothingOff) {
  const test::TempDir folder;
  Scene scene({{{channels({delivery("robot-can", true)})}}});
  Options options = scene.options();
  options.socket = folder.path("later.sock");
  options.longest_retry = std::chrono::hours(1);
  Client client(options);
  PublisherChannel stop(client, "stop");
  for (int i = 0; i < 30; ++i) EXPECT_EQ(stop.announce()->state, State::no_daemon);
  std::filesystem::create_symlink(scene.options().socket, options.socket);
  EXPECT_EQ(causes(exceptions(client, stop, 1)), Texts{"daemon-back"});
}

/// Its connections stay, and its gates too, until the grace is over.
TEST(Exceptions, ADaemonThatHangsIsGoneAndIsBackWhenItAnswersAgain) {
  Scene scene(
      {{{channels({delivery("robot-can", true)})}}, {{channels({delivery("robot-can", false)})}}});
  Options options = scene.options();
  options.answers_within = milliseconds(200);
  Client client(options);
  PublisherChannel stop(client, "stop");
  ASSERT_EQ(stop.announce()->state, State::granted);
  scene.hang(true);
  const auto gone = exceptions(client, stop, 1);
  EXPECT_EQ(causes(gone), Texts{"daemon-gone"});
  EXPECT_EQ(gone[0].text, "mlccad does not answer: nothing has come from it for 200 ms");
  EXPECT_EQ(stop.answer()->state, State::no_daemon);
  EXPECT_TRUE(client.is_connected()) << "it would fill the queue of its socket otherwise";
  scene.hang(false);
  const auto back = exceptions(client, stop, 1);
  EXPECT_EQ(causes(back), Texts{"daemon-back"});
  EXPECT_EQ(back[0].answer->state, State::refused) << "the decision may be another one";
}

TEST(Exceptions, WhatADaemonCannotAnswerIsAskedForLater) {
  Scene scene({{{error(control::ErrorKind::world, "no memory")}},
               {{channels({delivery("robot-can", true)})}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  EXPECT_EQ(stop.announce()->state, State::no_daemon);
  EXPECT_EQ(stop.answer()->reason, "no memory");
  EXPECT_EQ(causes(exceptions(client, stop, 1)), Texts{"daemon-back"});
}

/// This gateway has granted it, and asked the next one in vain.
TEST(Exceptions, ARefusalFurtherOnIsToldToSubscribers) {
  control::Reply further = event("refused");
  auto& said = std::get<control::Event>(further.body);
  said.network = "middle";
  said.message = "stop from middle: refused further on by 10.77.3.2: Latency 4 ms required";
  for (const bool subscribes : {true, false}) {
    Scene scene({{{channels({delivery("field", true)}), further, event("dropped")}},
                 {{channels({delivery("field", true)})}}});
    Client client(scene.options());
    SubscriberChannel subscriber(client, "stop");
    PublisherChannel publisher(client, "stop");
    Channel& channel = subscribes ? static_cast<Channel&>(subscriber) : publisher;
    if (subscribes)
      subscriber.subscribe();
    else
      publisher.announce();
    const auto all = exceptions(client, channel, subscribes ? 2 : 1);
    EXPECT_EQ(causes(all), subscribes ? (Texts{"refused", "dropped"}) : (Texts{"dropped"}));
    if (subscribes) {
      EXPECT_EQ(all[0].text, said.message);
    }
  }
}

TEST(Exceptions, AGrantFurtherOnIsToldToSubscribers) {
  control::Reply further = event("granted");
  std::get<control::Event>(further.body).network = "middle";
  Scene scene({{{channels({delivery("field", true)}), further, event("dropped")}}});
  Client client(scene.options());
  SubscriberChannel subscriber(client, "stop");
  subscriber.subscribe();
  EXPECT_EQ(causes(exceptions(client, subscriber, 2)), (Texts{"granted", "dropped"}));
  EXPECT_EQ(scene.requests().size(), 1U) << "nothing is decided otherwise here";
}

/// Another program may hold the port for a while.
TEST(Exceptions, EventsThatCannotBeCarriedAreTriedAgain) {
  control::Channels nowhere{{delivery("field", true)}, 0};
  nowhere.endpoints.emplace_back();
  nowhere.endpoints.back().network = "field";
  nowhere.endpoints.back().interface = "none0";
  nowhere.endpoints.back().ifindex = 999'999;
  Scene scene({{{{0, nowhere}}}, {{{0, nowhere}}}, {{channels({delivery("field", true)})}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  stop.announce();
  const auto all = exceptions(client, stop, 2);
  EXPECT_NE(all[0].text.find("its events cannot be carried: field: none0"), std::string::npos);
  EXPECT_EQ(all[1].text, "its events can be carried again") << "and the first one once";
}

/// The other events are carried meanwhile, and the program asks again by itself.
TEST(Exceptions, APlaceForEventsOfProgramsIsAskedForAgain) {
  control::Channels full{{delivery("field", true)}, 0};
  full.local_problem = "all places are taken";
  Scene scene({{{{0, full}}}, {{{0, full}}}, {{channels({delivery("field", true)})}}});
  Client client(scene.options());
  SubscriberChannel stop(client, "stop");
  EXPECT_EQ(stop.subscribe()->state, State::granted);
  const auto all = exceptions(client, stop, 2);
  EXPECT_EQ(all[0].text,
            "its events cannot be carried: programs on this gateway: all places are taken");
  EXPECT_EQ(all[1].text, "its events can be carried again") << "and the first one once";
  EXPECT_EQ(scene.requests().size(), 3U);
}

TEST(Exceptions, AHandlerKeepsItsState) {
  Scene scene({{{channels({delivery("robot-can", true)}), event("missing"), event("restored")}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  int seen = 0;
  stop.on_exception([&seen, n = 0](const Exception&) mutable { seen = ++n; });
  stop.announce();
  while (seen < 2) client.wait(kLong);
  EXPECT_EQ(seen, 2);
}

TEST(Exceptions, PatienceMayBeWithoutEnd) {
  for (const auto patience : {milliseconds(-1), milliseconds::max()}) {
    Scene scene({{{channels({delivery("robot-can", true)})}}});
    Options options = scene.options();
    options.patience = patience;
    Client client(options);
    PublisherChannel stop(client, "stop");
    EXPECT_EQ(stop.announce()->state, State::granted);
    client.wait(milliseconds(0));
  }
}

/// An answer outlives the next one.
TEST(Exceptions, AnAnswerStaysWhatItWas) {
  Scene scene(
      {{{channels({delivery("robot-can", true)})}}, {{channels({delivery("robot-can", false)})}}});
  Client client(scene.options());
  PublisherChannel stop(client, "stop");
  const auto first = stop.announce();
  EXPECT_EQ(stop.announce()->state, State::refused);
  EXPECT_EQ(first->state, State::granted);
}

}  // namespace
}  // namespace mlcca::client
