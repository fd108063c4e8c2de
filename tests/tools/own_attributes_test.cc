// SPDX-License-Identifier: BSD-2-Clause
// Attributes that the description defines: the daemon has it, and says whether there are such.
#include <gtest/gtest.h>

#include "tests/control/server.hpp"
#include "tests/tools/run.hpp"

namespace mlcca {
namespace {

test::Server::Handler done() {
  return [](const control::Request&) { return test::Server::Answer{{{0, control::Done{"fine"}}}}; };
}

TEST(OwnAttributesTest, AreAskedForAsTheyAreWritten) {
  test::Server server(done());
  const auto outcome = test::run_mlccactl({"--socket", server.path(), "query", "a", "--require",
                                           "Trust=4", "--offer", "Temperature=310.5 K"});
  EXPECT_EQ(outcome.status, 0) << outcome.error;
  control::ChannelRequest expected;
  expected.channel = "a";
  expected.required = {{.name = "Trust", .value = 4, .unit = "", .dynamic = false}};
  expected.offered = {{.name = "Temperature", .value = 3105, .unit = "1e-1 K", .dynamic = false}};
  ASSERT_EQ(server.requests().size(), 1U);
  EXPECT_EQ(server.requests().front(), (control::Request{1, control::Query{expected}}));
}

TEST(OwnAttributesTest, AreNotAnnounced) {
  test::Server server(done());
  const auto outcome = test::run_mlccactl(
      {"--socket", server.path(), "announce", "a", "publisher", "--state", "Trust=4"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_TRUE(outcome.error.contains("unknown attribute 'Trust'")) << outcome.error;
  EXPECT_TRUE(server.requests().empty());
}

}  // namespace
}  // namespace mlcca
