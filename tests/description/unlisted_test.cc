// SPDX-License-Identifier: BSD-2-Clause
// Which subjects an Unlisted allows, and what it refuses to guess.
#include <gtest/gtest.h>

#include <string>

#include "description/read.hpp"

namespace mlcca::description {
namespace {

std::string network_that_allows(const std::string& subjects) {
  return "<System name='t'>\n<Network name='lan'><Kind>udp-multicast</Kind>"
         "<Profile>famouso</Profile>\n<Unlisted allow='" +
         subjects + "'/></Network>\n</System>\n";
}

/// The first problem; empty: there is none.
std::string problem_of(const std::string& subjects) {
  const auto system = read_memory(network_that_allows(subjects), "t.xml");
  return system ? "" : to_string(system.error().front());
}

TEST(Unlisted, DemandsAllDigitsOfASubject) {
  for (const char* right : {"no", "any", "0x5600000000000000/8", "0x5600000000000001/64",
                            "0x8000000000000000/1", "0x0000000000000056/63"})
    EXPECT_EQ(problem_of(right), "") << right;
  for (const char* wrong : {"0x56/8", "0x560000000000000/8", "0x56000000000000000/8", "0x/8"})
    EXPECT_EQ(problem_of(wrong),
              "t.xml:3: <Unlisted>: attribute allow: '" + std::string(wrong) +
                  "' is not right: it must be no, any, or a subject of 16 hexadecimal digits and "
                  "how many of its leading bits count, such as 0x5600000000000000/8");
}

TEST(Unlisted, RefusesBitsThatCountForNothing) {
  EXPECT_EQ(problem_of("0x5600000000000001/8"),
            "t.xml:3: <Unlisted>: attribute allow: 0x5600000000000001/8 has bits behind its "
            "leading 8, which count for nothing: write 0x5600000000000000/8, or more bits");
  EXPECT_EQ(problem_of("0x5600000000000000/7"), "") << "its last bit that is 1 is the seventh";
  EXPECT_EQ(problem_of("0x5600000000000000/6"),
            "t.xml:3: <Unlisted>: attribute allow: 0x5600000000000000/6 has bits behind its "
            "leading 6, which count for nothing: write 0x5400000000000000/6, or more bits");
  EXPECT_NE(problem_of("0x0000000000000001/63"), "");
}

TEST(Unlisted, AllowsWhatBeginsWithTheseBits) {
  const auto system = read_memory(network_that_allows("0x5600000000000000/8"), "t.xml");
  ASSERT_TRUE(system);
  const core::UnlistedPolicy& policy = system->networks[0].unlisted;
  EXPECT_TRUE(policy.admits(0x5600000000000000));
  EXPECT_TRUE(policy.admits(0x56ffffffffffffff));
  EXPECT_FALSE(policy.admits(0x55ffffffffffffff));
  EXPECT_FALSE(policy.admits(0x5700000000000000));
}

}  // namespace
}  // namespace mlcca::description
