// SPDX-License-Identifier: BSD-2-Clause
#include <gtest/gtest.h>

#include "tests/control/messages.hpp"
#include "tools/render.hpp"

namespace mlcca::tools {
namespace {

TEST(RenderTransfersTest, RoutesShowWhatProgramsCarry) {
  control::Routes routes;
  routes.transfers = test::full_transfers().transfers;
  routes.transfers_left_out = 3;
  EXPECT_EQ(render(routes, Color::no), R"(no channel has a publisher and a subscriber

carried by programs
  CHANNEL           PUBLISHER  FROM  TO    USER
  emergency-switch  switch     can1  eth0   990
  and 3 more
)");
}

}  // namespace
}  // namespace mlcca::tools
