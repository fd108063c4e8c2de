// SPDX-License-Identifier: BSD-2-Clause
// The built program, end to end against a fake daemon: what it asks, prints and exits with.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/handle.hpp"
#include "control/version.hpp"
#include "tests/control/messages.hpp"
#include "tests/control/server.hpp"
#include "tests/tools/run.hpp"

namespace mlcca {
namespace {

using control::Reply;
using test::run_mlccactl;
using test::Server;
using Json = nlohmann::json;
using Arguments = std::vector<std::string>;

Server::Handler always(Reply reply) {
  return [reply](const control::Request&) { return Server::Answer{{reply}}; };
}

/// What the daemon was asked by `arguments`.
control::Request request_of(Arguments arguments) {
  Server server(always({0, control::Done{"fine"}}));
  arguments.insert(arguments.begin(), {"--socket", server.path()});
  const auto outcome = run_mlccactl(arguments);
  EXPECT_EQ(outcome.status, 0) << outcome.error;
  const auto requests = server.requests();
  EXPECT_EQ(requests.size(), 1U);
  return requests.empty() ? control::Request{} : requests.front();
}

/// Status and output of `arguments` when the daemon answers `reply`.
test::Outcome outcome_of(Arguments arguments, const Reply& reply) {
  Server server(always(reply));
  arguments.insert(arguments.end(), {"--socket", server.path()});
  return run_mlccactl(arguments);
}

Reply error_of(control::ErrorKind kind) {
  return {0, control::Error{kind, "this is wrong", {"here: so"}}};
}

TEST(MlccactlTest, AsksWhatEachVerbSays) {
  EXPECT_EQ(request_of({"status"}), (control::Request{1, control::StatusRequest{}}));
  EXPECT_EQ(request_of({"networks"}), (control::Request{1, control::NetworksRequest{}}));
  EXPECT_EQ(request_of({"channels"}), (control::Request{1, control::ChannelsRequest{}}));
  EXPECT_EQ(request_of({"reload"}), (control::Request{1, control::ReloadRequest{}}));
  EXPECT_EQ(request_of({"mode", "audit"}), (control::Request{1, control::ModeRequest{"audit"}}));
  EXPECT_EQ(request_of({"mode", "enforce"}),
            (control::Request{1, control::ModeRequest{"enforce"}}));
  EXPECT_EQ(request_of({"explain", "0xa4efeccc3210b497"}),
            (control::Request{1, control::ExplainRequest{"0xa4efeccc3210b497"}}));
  EXPECT_EQ(request_of({"release", "a"}),
            (control::Request{1, control::ReleaseRequest{"a", 0, ""}}));
  EXPECT_EQ(request_of({"release", "--id", "18446744073709551615"}),
            (control::Request{1, control::ReleaseRequest{"", ~std::uint64_t{0}, ""}}));
  EXPECT_EQ(request_of({"release", "--key", "blue"}),
            (control::Request{1, control::ReleaseRequest{"", 0, "blue"}}));
}

TEST(MlccactlTest, AsksAboutADeliveryWithAllThatWasSaid) {
  auto expected = test::full_channel_request();
  for (auto& attribute : expected.required) attribute.dynamic = false;
  const Arguments arguments = {"--from",       "second-can",   "--to",
                               "robot-can",    "--offer",      "Period=50ms",
                               "--offer",      "MaxPayload=8", "--require",
                               "Omission=2",   "--node",       "0",
                               "--priority",   "125",          "--user",
                               "1000",         "--publisher",  "switch",
                               "--subscriber", "motors",       "--from-node",
                               "laptop",       "--to-node",    "relay",
                               "--address",    "192.0.2.7",    "emergency-switch"};
  auto query = arguments;
  query.insert(query.begin(), "query");
  EXPECT_EQ(request_of(query), (control::Request{1, control::Query{expected}}));
  auto admit = arguments;
  admit.insert(admit.begin(), "admit");
  EXPECT_EQ(request_of(admit), (control::Request{1, control::Admit{expected}}));
}

TEST(MlccactlTest, AsksForAChannelThatIsNotDescribed) {
  control::ChannelRequest expected;
  expected.channel = "0x5600000000000001";
  expected.unlisted = true;
  expected.identifiers = {{.network = "robot-can", .id = 0x123, .extended = false},
                          {.network = "second-can", .id = 0x123, .extended = true},
                          {.network = "third=can", .id = 2048, .extended = true}};
  EXPECT_EQ(
      request_of({"query", "--subject", "0x5600000000000001", "--identifier", "robot-can=0x123",
                  "--identifier", "second-can=0x00000123", "--identifier", "third=can=2048"}),
      (control::Request{1, control::Query{expected}}));
}

TEST(MlccactlTest, AsksForRoutesReservationsAndRenewals) {
  EXPECT_EQ(request_of({"routes"}), (control::Request{1, control::RoutesRequest{}}));
  EXPECT_EQ(request_of({"reservations"}), (control::Request{1, control::ReservationsRequest{""}}));
  EXPECT_EQ(request_of({"reservations", "awds"}),
            (control::Request{1, control::ReservationsRequest{"awds"}}));
  EXPECT_EQ(request_of({"renew", "--admission", "7"}),
            (control::Request{1, control::RenewRequest{.admission = 7, .key = ""}}));
  EXPECT_EQ(request_of({"renew", "--key", "camera"}),
            (control::Request{1, control::RenewRequest{.admission = 0, .key = "camera"}}));
  EXPECT_EQ(request_of({"release", "--admission", "7"}),
            (control::Request{1, control::ReleaseRequest{"", 7, ""}}));
}

TEST(MlccactlTest, AsksWhatWouldBeWithOtherLinksAndWithoutPlaces) {
  control::WhatIfRequest expected;
  expected.links = {{.network = "",
                     .from = "relay-1",
                     .to = "02:00:00:00:00:03",
                     .rate = 6'000'000,
                     .one_way = false},
                    {.network = "awds", .from = "a.b", .to = "c", .rate = 0, .one_way = false}};
  expected.without = {"second-can", "bridge"};
  Arguments arguments = {"what-if",    "--link",       "relay-1,02:00:00:00:00:03=6Mbit/s",
                         "--link",     "awds/a.b,c=0", "--without",
                         "second-can", "--without",    "bridge"};
  EXPECT_EQ(request_of(arguments), (control::Request{1, expected}));
  for (auto& link : expected.links) link.one_way = true;
  arguments.emplace_back("--one-way");
  EXPECT_EQ(request_of(arguments), (control::Request{1, expected}));
}

TEST(MlccactlTest, AsksForAPartOfTheHistory) {
  EXPECT_EQ(request_of({"history"}), (control::Request{1, control::HistoryRequest{}}));
  EXPECT_EQ(request_of({"history", "--channel", "video", "--kind", "degraded", "--since",
                        "@1700000000", "--until", "@1700000001", "--limit", "7"}),
            (control::Request{1, control::HistoryRequest{.channel = "video",
                                                         .kind = "degraded",
                                                         .since_unix_ns = 1'700'000'000'000'000'000,
                                                         .until_unix_ns = 1'700'000'001'000'000'000,
                                                         .limit = 7}}));
  const auto before = std::chrono::system_clock::now().time_since_epoch();
  const auto request = request_of({"history", "--since", "-1h"});
  const auto after = std::chrono::system_clock::now().time_since_epoch();
  const std::chrono::nanoseconds since(
      std::get<control::HistoryRequest>(request.body).since_unix_ns);
  EXPECT_GE(since, before - std::chrono::hours(1));
  EXPECT_LE(since, after - std::chrono::hours(1));
}

/// What admit asks for with `arguments`.
control::Admit admit_of(Arguments arguments) {
  arguments.insert(arguments.begin(), {"admit", "a"});
  const auto request = request_of(arguments);
  const auto* admit = std::get_if<control::Admit>(&request.body);
  EXPECT_NE(admit, nullptr);
  return admit == nullptr ? control::Admit{} : *admit;
}

TEST(MlccactlTest, AsksForALeaseAndAHold) {
  control::Admit expected;
  expected.channel = "a";
  EXPECT_EQ(admit_of({}), expected);
  expected.key = "camera";
  expected.lease_ns = 90'000'000'000;
  EXPECT_EQ(admit_of({"--key", "camera", "--lease", "1min 30s"}), expected);
  expected.hold = true;
  EXPECT_EQ(admit_of({"--key", "camera", "--lease", "90s", "--hold"}), expected);
  expected.lease_ns = 10'000'000'000;
  EXPECT_EQ(admit_of({"--key", "camera", "--hold"}), expected) << "10 s without a word";
}

TEST(MlccactlTest, SaysHowALeaseIsRenewed) {
  const Reply granted{0, control::Channels{{test::granted_channel(), test::granted_channel()}}};
  const auto leased = outcome_of({"admit", "a", "--lease", "30s"}, granted);
  EXPECT_EQ(leased.status, 0);
  EXPECT_TRUE(
      leased.out.ends_with("released in 30 s unless it is renewed\n"
                           "  mlccactl renew --id 7 renews it\n"))
      << leased.out;
  const auto json = outcome_of({"admit", "a", "--lease", "30s", "--json"}, granted);
  EXPECT_TRUE(Json::parse(json.out, nullptr, false).is_object()) << json.out;
  const auto unlimited = outcome_of({"admit", "a"}, granted);
  EXPECT_EQ(unlimited.out.find("renew"), std::string::npos) << unlimited.out;
  const auto refused = outcome_of({"admit", "a", "--lease", "30s"},
                                  {0, control::Channels{{test::refused_channel()}}});
  EXPECT_EQ(refused.status, 1);
  EXPECT_EQ(refused.out.find("renew"), std::string::npos) << refused.out;
}

control::Event event_of(const char* kind, std::vector<std::uint64_t> admissions) {
  auto event = test::full_event();
  event.kind = kind;
  event.admissions = std::move(admissions);
  return event;
}

Reply granted_as_7() { return {0, control::Channels{{test::granted_channel()}}}; }

TEST(MlccactlTest, GateReportsWhatTheStatusKnowsOfItsInterface) {
  auto gates = test::full_gates();
  gates.gates.resize(1);
  auto status = test::full_status();
  status.interfaces[0].name = gates.gates[0].interface;
  status.interfaces[0].network = gates.gates[0].network;
  status.interfaces[0].hook = "tcx";
  Server server([&](const control::Request& request) -> Server::Answer {
    if (std::holds_alternative<control::GateRequest>(request.body)) return {{{0, gates}}};
    return {{{0, status}}};
  });
  const auto outcome = run_mlccactl({"gate", "can0", "--socket", server.path()});
  EXPECT_EQ(outcome.status, 0) << outcome.error;
  EXPECT_NE(outcome.out.find("attached by tcx"), std::string::npos) << outcome.out;
  ASSERT_EQ(server.requests().size(), 2U);
  EXPECT_EQ(server.requests()[0].body,
            (decltype(control::Request::body){control::GateRequest{"can0"}}));
}

TEST(MlccactlTest, AnnouncesAnEndWithWhatTheProgramStates) {
  EXPECT_EQ(
      request_of({"announce", "a", "subscriber"}),
      (control::Request{1, control::AnnounceRequest{"a", control::Role::subscriber, "", {}}}));
  EXPECT_EQ(
      request_of({"announce", "a", "publisher", "--name", "lever", "--state", "Period=50ms"}),
      (control::Request{
          1, control::AnnounceRequest{
                 "a",
                 control::Role::publisher,
                 "lever",
                 {{.name = "Period", .value = 50'000'000, .unit = "ns", .dynamic = false}}}}));
  EXPECT_EQ(outcome_of({"announce", "a", "reader"}, granted_as_7()).status, 2);
  EXPECT_EQ(outcome_of({"announce", "a", "publisher"}, granted_as_7()).status, 0);
  EXPECT_EQ(
      outcome_of({"announce", "a", "publisher"}, {0, control::Channels{{test::refused_channel()}}})
          .status,
      1);
  EXPECT_EQ(
      outcome_of({"announce", "a", "publisher"}, error_of(control::ErrorKind::forbidden)).status,
      3);
}

TEST(MlccactlTest, AnnounceFollowsTheChannelAlsoWhileItIsRefused) {
  Server server([](const control::Request&) {
    return Server::Answer{
        {{0, control::Channels{{test::refused_channel()}}}, {0, event_of("granted", {})}}, true};
  });
  const auto outcome = run_mlccactl(
      {"announce", "a", "publisher", "--follow", "--socket", server.path()}, {"TZ=UTC"});
  EXPECT_TRUE(outcome.out.starts_with("refused")) << outcome.out;
  EXPECT_NE(outcome.out.find("2023-11-14 22:13:20.123  granted "), std::string::npos)
      << outcome.out;
}

TEST(MlccactlTest, HoldPrintsWhatHappensUntilTheDaemonEnds) {
  Server server([](const control::Request&) {
    return Server::Answer{{granted_as_7(),
                           {0, event_of("withdrawn", {7})},
                           {0, event_of("released", {8})},
                           {0, event_of("granted", {7})}},
                          true};
  });
  const auto outcome =
      run_mlccactl({"admit", "a", "--hold", "--socket", server.path()}, {"TZ=UTC"});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_EQ(outcome.error, "mlccactl: mlccad closed the connection\n");
  EXPECT_TRUE(outcome.out.starts_with("granted  emergency-switch"));
  const std::string rest =
      "emergency-switch (0xa4efeccc3210b497) on robot-can: Omission 2 "
      "required, bridge provides 5\n";
  EXPECT_TRUE(outcome.out.ends_with(
      "held until Ctrl-C or the end of a pipe on standard input; 10 s later it is released\n"
      "2023-11-14 22:13:20.123  withdrawn  " +
      rest + "2023-11-14 22:13:20.123  released   " + rest +
      "2023-11-14 22:13:20.123  granted    " + rest))
      << outcome.out;
}

TEST(MlccactlTest, HoldPrintsObjectsOnlyWhereJsonIsAskedFor) {
  Server server([](const control::Request&) {
    return Server::Answer{{granted_as_7(), {0, event_of("released", {7})}}};
  });
  const auto outcome = run_mlccactl({"admit", "a", "--hold", "--json", "--socket", server.path()});
  std::istringstream lines(outcome.out);
  std::string line;
  std::vector<Json> objects;
  while (std::getline(lines, line)) objects.push_back(Json::parse(line, nullptr, false));
  ASSERT_EQ(objects.size(), 2U) << outcome.out;
  EXPECT_TRUE(objects[0].contains("channels"));
  EXPECT_EQ(objects[1].at("admissions"), Json{7});
}

TEST(MlccactlTest, HoldEndsWhenAnotherClientReleasesIt) {
  Server server([](const control::Request&) {
    return Server::Answer{{granted_as_7(), {0, event_of("released", {6, 7})}}};
  });
  const auto outcome = run_mlccactl({"admit", "a", "--hold", "--socket", server.path()});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.error, "");
}

TEST(MlccactlTest, HoldEndsWithItsInput) {
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe2(pipe.data(), O_CLOEXEC), 0);
  const Fd input(pipe[0]);
  Fd other(pipe[1]);
  ASSERT_EQ(::write(other.get(), "what is typed\n", 14), 14);
  other.reset();
  Server server(always(granted_as_7()));
  const auto outcome =
      run_mlccactl({"admit", "a", "--hold", "--socket", server.path()}, {}, nullptr, input.get());
  EXPECT_EQ(outcome.status, 0) << outcome.error;
}

TEST(MlccactlTest, HoldsNothingThatIsRefused) {
  const auto outcome =
      outcome_of({"admit", "a", "--hold"}, {0, control::Channels{{test::refused_channel()}}});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.out.find("held"), std::string::npos);
  EXPECT_EQ(outcome_of({"admit", "a", "--hold"}, error_of(control::ErrorKind::forbidden)).status,
            3);
}

TEST(MlccactlTest, ExitsWith1WhenADeliveryWouldLose) {
  auto what_if = test::full_what_if();
  const Arguments arguments{"what-if", "--without", "bridge"};
  EXPECT_EQ(outcome_of(arguments, {0, what_if}).status, 1);
  what_if.outlooks.pop_back();  // the loser
  EXPECT_EQ(outcome_of(arguments, {0, what_if}).status, 0);
  EXPECT_EQ(outcome_of(arguments, {0, control::WhatIf{}}).status, 0);
  EXPECT_EQ(
      outcome_of({"what-if", "--without", "bridge", "--json"}, {0, test::full_what_if()}).status,
      1);
}

TEST(MlccactlTest, AsksForChannelsWhoseNameLooksLikeAnOption) {
  EXPECT_EQ(request_of({"explain", "--", "-x"}),
            (control::Request{1, control::ExplainRequest{"-x"}}));
}

TEST(MlccactlTest, ExitsWith0WhenGrantedAnd1WhenRefused) {
  const Reply granted{0, control::Channels{{test::granted_channel()}}};
  const Reply mixed{0, control::Channels{{test::granted_channel(), test::refused_channel()}}};
  const Reply nothing{0, control::Channels{}};
  for (const auto* verb : {"query", "admit", "explain"}) {
    EXPECT_EQ(outcome_of({verb, "a"}, granted).status, 0) << verb;
    EXPECT_EQ(outcome_of({verb, "a"}, mixed).status, 1) << verb;
    EXPECT_EQ(outcome_of({verb, "a"}, nothing).status, 1) << verb;
    EXPECT_EQ(outcome_of({verb, "a", "--json"}, granted).status, 0) << verb;
    EXPECT_EQ(outcome_of({verb, "a", "--json"}, mixed).status, 1) << verb;
  }
  EXPECT_EQ(outcome_of({"channels"}, mixed).status, 0);
}

TEST(MlccactlTest, WithdrawsAndReinstatesWhatIsNamed) {
  EXPECT_EQ(request_of({"withdraw", "a", "--yes", "--json"}),
            (control::Request{1, control::WithdrawRequest{"a"}}));
  EXPECT_EQ(request_of({"reinstate", "a"}), (control::Request{1, control::ReinstateRequest{"a"}}));
}

TEST(MlccactlTest, WithdrawsNothingWhereNoPersonCanBeAsked) {
  std::size_t asked = 0;
  Server server([&](const control::Request& request) {
    ++asked;
    EXPECT_TRUE(std::holds_alternative<control::ExplainRequest>(request.body));
    return Server::Answer{{granted_as_7()}};
  });
  const auto outcome = run_mlccactl({"withdraw", "a", "--socket", server.path()});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.error.find("state --yes"), std::string::npos) << outcome.error;
  EXPECT_EQ(asked, 1U);
}

TEST(MlccactlTest, ExitsWith2WhenTheDaemonCannotUseTheInput) {
  for (const auto kind : {control::ErrorKind::invalid, control::ErrorKind::unreadable}) {
    const auto outcome = outcome_of({"reload"}, error_of(kind));
    EXPECT_EQ(outcome.status, 2);
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(outcome.error, "mlccactl: this is wrong\n  here: so\n");
  }
}

TEST(MlccactlTest, ExitsWith3WhenTheDaemonOrTheWorldFails) {
  for (const auto kind :
       {control::ErrorKind::forbidden, control::ErrorKind::world, control::ErrorKind::unspecified})
    EXPECT_EQ(outcome_of({"reload"}, error_of(kind)).status, 3);
}

TEST(MlccactlTest, PrintsErrorsAsJsonWhereJsonIsAskedFor) {
  const auto outcome = outcome_of({"reload", "--json"}, error_of(control::ErrorKind::world));
  EXPECT_EQ(outcome.status, 3);
  EXPECT_EQ(Json::parse(outcome.out).at("error").at("kind"), "world");
  EXPECT_EQ(outcome.error, "");
}

TEST(MlccactlTest, ExitsWith3WithoutADaemon) {
  const test::TempDir directory;
  const auto path = directory.path("none.sock");
  for (const Arguments& verb : {Arguments{"status"}, Arguments{"monitor"}, Arguments{"routes"},
                                Arguments{"admit", "a"}, Arguments{"history"}}) {
    auto arguments = verb;
    arguments.insert(arguments.end(), {"--socket", path});
    const auto outcome = run_mlccactl(arguments);
    EXPECT_EQ(outcome.status, 3);
    EXPECT_EQ(outcome.error, "mlccactl: no daemon: " + path + ": No such file or directory\n");
  }
}

TEST(MlccactlTest, ExitsWith3WhenTheDaemonIsSilent) {
  const test::TempDir directory;
  const auto listener = test::listen_at(directory.path("mute.sock"));
  const auto outcome =
      run_mlccactl({"status", "--timeout", "0.01", "--socket", directory.path("mute.sock")});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_EQ(outcome.error, "mlccactl: no answer from mlccad within 10 ms\n");
}

TEST(MlccactlTest, ExitsWith3WhenItsOutputIsLost) {
  Server server(always({0, test::full_status()}));
  const auto outcome = run_mlccactl({"status", "--socket", server.path()}, {}, "/dev/full");
  EXPECT_EQ(outcome.status, 3);
  EXPECT_EQ(outcome.error, "mlccactl: standard output: No space left on device\n");
}

TEST(MlccactlTest, TakesTheSocketFromTheEnvironment) {
  Server server(always({0, control::Done{"done it"}}));
  const auto outcome = run_mlccactl({"reload"}, {"MLCCA_SOCKET=" + server.path()});
  EXPECT_EQ(outcome.status, 0) << outcome.error;
  EXPECT_EQ(outcome.out, "done it\n");
}

TEST(MlccactlTest, PrintsNoColourIntoAFile) {
  const auto outcome = outcome_of({"status"}, {0, test::full_status()});
  EXPECT_EQ(outcome.out.find('\x1b'), std::string::npos);
  EXPECT_TRUE(outcome.out.starts_with("gateway      bridge of robot\n")) << outcome.out;
}

struct MlccactlJsonTest : ::testing::TestWithParam<const char*> {};

TEST_P(MlccactlJsonTest, PrintsOneObjectOnOneLine) {
  for (const auto& [name, reply] : test::all_replies()) {
    if (std::holds_alternative<control::Event>(reply.body)) continue;
    const auto outcome = outcome_of({GetParam(), "--json"}, {0, reply.body});
    const auto json = Json::parse(outcome.out, nullptr, false);
    EXPECT_TRUE(json.is_object()) << name << ": " << outcome.out;
    EXPECT_EQ(outcome.out.find('\n'), outcome.out.size() - 1) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Verbs, MlccactlJsonTest,
                         ::testing::Values("status", "networks", "channels", "reload", "routes",
                                           "reservations", "subscriptions", "history"),
                         [](const auto& row) { return std::string(row.param); });

/// Two events and the end of the daemon.
Server::Answer two_events(const control::Request&) {
  return {{{0, control::Done{}}, {0, test::full_event()}, {0, test::full_event()}}, true};
}

TEST(MlccactlTest, MonitorPrintsALineForEachEventUntilTheDaemonEnds) {
  Server server(two_events);
  const auto outcome = run_mlccactl({"monitor", "--socket", server.path()}, {"TZ=UTC"});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_EQ(outcome.error, "mlccactl: mlccad closed the connection\n");
  const std::string line =
      "2023-11-14 22:13:20.123  refused    emergency-switch (0xa4efeccc3210b497) on robot-can: "
      "Omission 2 required, bridge provides 5\n";
  EXPECT_EQ(outcome.out, line + line);
}

TEST(MlccactlTest, MonitorPrintsAnObjectForEachEvent) {
  Server server(two_events);
  const auto outcome = run_mlccactl({"--json", "monitor", "--socket", server.path()});
  std::istringstream lines(outcome.out);
  std::string line;
  std::vector<Json> objects;
  while (std::getline(lines, line)) objects.push_back(Json::parse(line, nullptr, false));
  ASSERT_EQ(objects.size(), 3U);
  EXPECT_EQ(objects[0].at("kind"), "refused");
  EXPECT_EQ(objects[1].at("unix_ns"), 1'700'000'000'123'456'789);
  EXPECT_TRUE(objects[2].contains("error"));
}

TEST(MlccactlTest, MonitorReportsThatItIsNotPossible) {
  EXPECT_EQ(outcome_of({"monitor"}, error_of(control::ErrorKind::world)).status, 3);
}

TEST(MlccactlTest, HelpAndVersionAreFine) {
  const auto help = run_mlccactl({"--help"});
  EXPECT_EQ(help.status, 0);
  EXPECT_NE(help.out.find("Exit status"), std::string::npos);
  EXPECT_TRUE(run_mlccactl({"status", "--help"}).out.contains("With --check: 0 healthy, 1 degra"));
  const auto version = run_mlccactl({"--version"});
  EXPECT_EQ(version.status, 0);
  EXPECT_EQ(version.out, std::string("mlccactl ") + kVersion + "\n");
}

}  // namespace
}  // namespace mlcca
