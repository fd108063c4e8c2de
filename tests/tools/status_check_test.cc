// SPDX-License-Identifier: BSD-2-Clause
// mlccactl status --check, as monitoring systems run it.
#include <gtest/gtest.h>

#include "tests/control/messages.hpp"
#include "tests/control/server.hpp"
#include "tests/tools/run.hpp"

namespace mlcca {
namespace {

using test::run_mlccactl;
using test::Server;

Server::Handler always(control::Reply reply) {
  return [reply](const control::Request&) { return Server::Answer{{reply}}; };
}

TEST(StatusCheck, ExitsAsMonitoringSystemsTakeIt) {
  auto status = test::full_status();
  const auto check = [&](control::HealthState state) {
    status.health.state = state;
    Server server(always({0, status}));
    return run_mlccactl({"status", "--check", "--socket", server.path()});
  };
  using control::HealthState;
  EXPECT_EQ(check(HealthState::healthy).status, 0);
  EXPECT_EQ(check(HealthState::degraded).status, 1);
  EXPECT_EQ(check(HealthState::degraded).out,
            "DEGRADED: can1 is missing; 1 delivery is refused; and 5 more\n");
  EXPECT_EQ(check(HealthState::closed).status, 2);
  EXPECT_EQ(check(HealthState::unknown).status, 3);
  Server server(always({0, test::full_status()}));
  EXPECT_EQ(
      run_mlccactl({"--json", "status", "--check", "--socket", server.path()}).out,
      R"({"health":{"state":"degraded","reasons":["can1 is missing","1 delivery is refused"],)"
      "\"left_out\":5}}\n");
}

/// A monitoring system shows what stands on standard output, and takes 2 for closed gates.
TEST(StatusCheck, SaysInOneLineThatTheHealthIsUnknown) {
  const auto no_daemon = run_mlccactl({"status", "--check", "--socket", "/nonexistent"});
  EXPECT_EQ(no_daemon.status, 3);
  EXPECT_EQ(no_daemon.out, "UNKNOWN: no daemon: /nonexistent: No such file or directory\n");
  EXPECT_EQ(no_daemon.error, "");
  Server server(always({0, control::Error{control::ErrorKind::invalid, "this is wrong", {}}}));
  const auto refused = run_mlccactl({"status", "--check", "--socket", server.path()});
  EXPECT_EQ(refused.status, 3);
  EXPECT_EQ(refused.out, "UNKNOWN: this is wrong\n");
}

}  // namespace
}  // namespace mlcca
