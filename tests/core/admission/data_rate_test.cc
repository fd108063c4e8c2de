// SPDX-License-Identifier: BSD-2-Clause
// Frames with a data phase on a bus whose bit rates only its interfaces know.
#include <gtest/gtest.h>

#include "core/admission/state.hpp"
#include "tests/core/robot.hpp"

namespace mlcca::core::testing {
namespace {

TEST(DataRateTest, AnInterfaceThatIsSetUpWithoutOneCarriesNoSuchFrames) {
  System system = robot(0);
  system.networks[kRobotCan].bus.bitrate = 0;
  system.networks[kRobotCan].bindings.at(0).format = FrameFormat::fd;
  ASSERT_FALSE(system.gateways[kBridge].ports.empty());
  for (Port& port : system.gateways[kBridge].ports) {
    port.managed = true;
    port.bitrate = 500'000;
  }
  EXPECT_EQ(State(system).decisions()[0].verdicts.at(0).obstacle, Obstacle::no_data_rate);
  for (Port& port : system.gateways[kBridge].ports) port.data_bitrate = 2'000'000;
  EXPECT_EQ(State(system).decisions()[0].verdicts.at(0).obstacle, Obstacle::none);
}

}  // namespace
}  // namespace mlcca::core::testing
