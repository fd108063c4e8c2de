// SPDX-License-Identifier: BSD-2-Clause
// mlccactl rollout: what `check` finds is a reason against it, and Ctrl-C gives it up.
#include <gtest/gtest.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): kill() of POSIX
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "tests/control/server.hpp"
#include "tests/tools/programs/run.hpp"

namespace mlcca {
namespace {

constexpr const char* kBegin = R"(<System name="t">
<EventChannel name="c0"><SubjectUID>0x1</SubjectUID></EventChannel>
<Network name="lan"><Kind>udp-multicast</Kind><Profile>famouso</Profile><Provision>
<Attribute><Name>MaxPayload</Name><Dimension><SIUnit><Bytes>1</Bytes></SIUnit></Dimension>
<Value>64</Value></Attribute>
</Provision></Network>
<Gateway name="gw1"><Port network="lan"><Interface name="lan0"/></Port></Gateway>
)";
constexpr const char* kSubscriber = "<Subscriber channel=\"c0\" network=\"lan\"/>\n";

class RolloutVerb : public testing::Test {
 protected:
  explicit RolloutVerb() { write(kBegin); }
  void write(const std::string& text) {
    std::ofstream(folder.path("system.xml")) << text << "</System>\n";
  }
  test::End roll_out(const std::string& socket, std::vector<std::string> options) {
    std::vector<std::string> arguments{"--socket", socket, "rollout"};
    std::ranges::move(options, std::back_inserter(arguments));
    return test::run(
        {.program = "mlccactl", .arguments = std::move(arguments), .environment = {}, .input = {}});
  }
  std::string system() { return folder.path("system.xml"); }

  test::TempDir folder;
};

/// Sends SIGINT to the programs that this one has started.
void interrupt_children() {
  const std::string parent = "\nPPid:\t" + std::to_string(::getpid()) + "\n";
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    std::ifstream file(entry.path() / "status");
    const std::string status{std::istreambuf_iterator<char>(file), {}};
    if (status.find(parent) != std::string::npos) ::kill(std::stoi(name), SIGINT);
  }
}

control::Reply state(const std::string& words, const std::string& why = {}) {
  control::Rollout out;
  out.number = 1;
  out.state = words;
  out.why = why;
  return {0, out};
}

TEST_F(RolloutVerb, WhatCheckFindsIsAReasonAgainstItUnlessForced) {
  write(std::string(kBegin) + kSubscriber);
  const auto refused = roll_out("/nonexistent", {system()});
  EXPECT_EQ(refused.status, 1) << refused.error;
  EXPECT_NE(refused.error.find("it is not rolled out"), std::string::npos) << refused.error;
  EXPECT_NE(refused.error.find("MLCCA010"), std::string::npos) << refused.error;
  EXPECT_NE(refused.error.find("--force"), std::string::npos) << refused.error;
  EXPECT_EQ(roll_out("/nonexistent", {system(), "--force"}).status, 3) << "there is no daemon";
}

TEST_F(RolloutVerb, WhatHasNoErrorsIsHandedOver) {
  test::Server server(
      [](const control::Request&) -> test::Server::Answer { return {{state("in-force")}}; });
  const auto done = roll_out(server.path(), {system()});
  EXPECT_EQ(done.status, 0) << done.error;
  const auto requests = server.requests();
  ASSERT_FALSE(requests.empty());
  const auto* first = std::get_if<control::RolloutRequest>(&requests.front().body);
  ASSERT_NE(first, nullptr);
  EXPECT_FALSE(first->force);
  EXPECT_NE(first->part.find("<System"), std::string::npos);
}

TEST_F(RolloutVerb, ForceIsHandedOn) {
  write(std::string(kBegin) + kSubscriber);
  test::Server server(
      [](const control::Request&) -> test::Server::Answer { return {{state("in-force")}}; });
  EXPECT_EQ(roll_out(server.path(), {system(), "--force"}).status, 0);
  const auto requests = server.requests();
  ASSERT_FALSE(requests.empty());
  EXPECT_TRUE(std::get<control::RolloutRequest>(requests.front().body).force);
}

TEST_F(RolloutVerb, ControlCGivesItUp) {
  std::atomic<bool> cancelled = false;
  test::Server server([&](const control::Request& request) -> test::Server::Answer {
    if (const auto* rollout = std::get_if<control::RolloutRequest>(&request.body)) {
      cancelled = cancelled || rollout->cancel;
      return {{state("judged")}};
    }
    if (cancelled) return {{state("refused", "gw1: an operator has given it up at gw1")}};
    interrupt_children();
    return {{state("judged")}};
  });
  const auto end = roll_out(server.path(), {system()});
  EXPECT_EQ(end.status, 1) << end.error;
  EXPECT_TRUE(cancelled);
  EXPECT_NE(end.out.find("an operator has given it up"), std::string::npos) << end.out;
}

TEST_F(RolloutVerb, CancelWaitsUntilItIsGivenUp) {
  std::atomic<int> asked = 0;
  test::Server server([&](const control::Request& request) -> test::Server::Answer {
    control::Rollout now;
    now.state = "refused";
    now.current = "aa";
    now.open = true;
    if (std::holds_alternative<control::RolloutRequest>(request.body) || asked++ == 0)
      now.next = "bb";
    return {{{0, now}}};
  });
  EXPECT_EQ(roll_out(server.path(), {"--cancel"}).status, 0);
  EXPECT_EQ(asked, 2);
}

TEST_F(RolloutVerb, WhatHasComeIntoForceAllTheSameIsNotGivenUp) {
  test::Server server([&](const control::Request& request) -> test::Server::Answer {
    control::Rollout now;
    now.state = "in-force";
    now.current = "bb";
    now.open = std::holds_alternative<control::RolloutStateRequest>(request.body);
    return {{{0, now}}};
  });
  EXPECT_EQ(roll_out(server.path(), {"--cancel"}).status, 1);
}

TEST_F(RolloutVerb, CancelGoesAlone) {
  for (const std::string other : {"--back", "--accept"})
    EXPECT_EQ(roll_out("/nonexistent", {"--cancel", other}).status, 2) << other;
}

}  // namespace
}  // namespace mlcca
