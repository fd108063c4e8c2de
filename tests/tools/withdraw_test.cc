// SPDX-License-Identifier: BSD-2-Clause
// What mlccactl withdraw says to a person.
#include <gtest/gtest.h>

#include "tests/control/messages.hpp"
#include "tests/control/server.hpp"
#include "tests/tools/run.hpp"

namespace mlcca {
namespace {

TEST(WithdrawTest, SaysWhatStopsAlsoWhereNobodyIsAsked) {
  test::Server server([](const control::Request& request) {
    if (std::holds_alternative<control::ExplainRequest>(request.body))
      return test::Server::Answer{{{0, control::Channels{{test::granted_channel()}}}}};
    return test::Server::Answer{{{0, control::Done{"withdrawn"}}}};
  });
  const auto outcome = test::run_mlccactl({"withdraw", "a", "--yes", "--socket", server.path()});
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.out, "withdrawn\n");
  EXPECT_TRUE(outcome.error.contains(
      "a, once it is withdrawn: 1 delivery stops; everything of it is refused"))
      << outcome.error;
  EXPECT_TRUE(outcome.error.contains("  stops  from ")) << outcome.error;
  EXPECT_FALSE(outcome.error.contains("[y/N]")) << outcome.error;
}

TEST(WithdrawTest, SaysNotWhatStopsWhereItIsRefused) {
  test::Server server([](const control::Request& request) {
    if (std::holds_alternative<control::ExplainRequest>(request.body))
      return test::Server::Answer{{{0, control::Channels{{test::granted_channel()}}}}};
    return test::Server::Answer{
        {{0, control::Error{control::ErrorKind::forbidden, "this is for members", {}}}}};
  });
  const auto outcome = test::run_mlccactl({"withdraw", "a", "--yes", "--socket", server.path()});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.error, "mlccactl: this is for members\n");
}

}  // namespace
}  // namespace mlcca
