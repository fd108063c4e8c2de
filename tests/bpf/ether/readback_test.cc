// SPDX-License-Identifier: BSD-2-Clause
// What is in force at a real Ethernet device is read back, and what is wrong with it is named.
#include "daemon/gates/readback.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/bpf/ether/sockets_fixture.hpp"
#include "tests/daemon/gates/all_problems.hpp"

namespace mlcca::gates {
namespace {

class EtherReadback : public EtherSockets {
 protected:
  /// Above the folder of this layout.
  [[nodiscard]] std::string root() const {
    return std::filesystem::path(control_.directory()).parent_path();
  }
};

INSTANTIATE_TEST_SUITE_P(By, EtherReadback, ::testing::ValuesIn(hooks()), name_of);

TEST_P(EtherReadback, IsWhatWasPutThere) {
  SlotSpec refused = slot(Direction::ingress, kSubject + 1);
  refused.pass = false;
  admit({slot(Direction::ingress), refused});
  const auto reading = read_back(root());
  ASSERT_TRUE(reading) << reading.error().text;
  EXPECT_TRUE(reading->open);
  ASSERT_EQ(reading->gates.size(), 1U);
  const GateReading& gate = reading->gates[0];
  EXPECT_EQ(all_problems(gate), "");
  EXPECT_EQ(gate.interface, "eth0");
  EXPECT_EQ(gate.hook, GetParam());
  EXPECT_TRUE(gate.ethernet);
  EXPECT_TRUE(gate.readable);
  EXPECT_EQ(gate.slots.size(), 2U);
  for (const SlotSpec& there : gate.slots) EXPECT_EQ(there.pass, there.subject == kSubject);
}

TEST_P(EtherReadback, NamesAGateThatSomebodyRemoved) {
  remove_gate();
  const auto reading = read_back(root());
  ASSERT_TRUE(reading) << reading.error().text;
  const std::string problems = all_problems(reading->gates.at(0));
  EXPECT_TRUE(problems.contains("no program of ours is attached at ingress")) << problems;
  EXPECT_TRUE(problems.contains("no program of ours is attached at egress")) << problems;
}

}  // namespace
}  // namespace mlcca::gates
