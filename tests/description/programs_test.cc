// SPDX-License-Identifier: BSD-2-Clause
// Which programs may take up an end on a gateway.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "description/read.hpp"

namespace mlcca::description {
namespace {

std::string system(const std::string& publisher, const std::string& subscriber) {
  return fmt::format(
      "<System name=\"t\"><EventChannel name=\"c\"><SubjectUID>0x1</SubjectUID></EventChannel>"
      "<Network name=\"n\"><Kind>other</Kind></Network>"
      "<Gateway name=\"g\"><Port network=\"n\"><Interface name=\"eth0\"/></Port></Gateway>"
      "<Publisher channel=\"c\" gateway=\"g\" user=\"0\"{}/><Subscriber channel=\"c\"{}/></System>",
      publisher, subscriber);
}

std::vector<std::string> problems_of(const std::string& text) {
  std::vector<std::string> out;
  if (const auto read = read_memory(text, "t.xml"); !read)
    for (const auto& p : read.error()) out.push_back(to_string(p));
  return out;
}

TEST(ProgramRules, AreKeptOnceForAllEndsThatStateThem) {
  const auto read = read_memory(system(" group=\"0\" unit=\"lever@1.service\"",
                                       " gateway=\"g\" group=\"0\" unit=\"lever@1.service\""),
                                "t.xml");
  ASSERT_TRUE(read);
  ASSERT_EQ(read->program_rules.size(), 1U);
  EXPECT_EQ(read->program_rules[0].gid, 0U);
  EXPECT_EQ(read->program_rules[0].group, "0");
  EXPECT_EQ(read->program_rules[0].unit, "lever@1.service");
  EXPECT_EQ(read->publishers.at(0).program_rule, 0U);
  EXPECT_EQ(read->subscribers.at(0).program_rule, 0U);
  const auto without = read_memory(system("", " gateway=\"g\""), "t.xml");
  ASSERT_TRUE(without);
  EXPECT_EQ(without->publishers.at(0).program_rule, core::kAnyProgram);
}

TEST(ProgramRules, ANameThatIsNotKnownIsAnError) {
  EXPECT_EQ(problems_of(system(" group=\"no-such-group\"", " gateway=\"g\"")),
            std::vector<std::string>{
                "t.xml:1: <Publisher>: attribute group: group no-such-group is not known on this "
                "machine: add the group or give a number"});
  EXPECT_EQ(problems_of(system(" group=\"4294967295\"", " gateway=\"g\"")),
            std::vector<std::string>{
                "t.xml:1: <Publisher>: attribute group: group 4294967295 is not a group number: at "
                "most 4294967294"});
  EXPECT_EQ(
      read_memory(system(" group=\"root\"", " gateway=\"g\""), "t.xml")->program_rules.at(0).gid,
      0U);
}

TEST(ProgramRules, AUnitHasTheFormOfOne) {
  for (const char* right : {"a.service", "a-b_c:1@x.service", "session-2.scope", "a\\x2d.service"})
    EXPECT_TRUE(problems_of(system(fmt::format(" unit=\"{}\"", right), " gateway=\"g\"")).empty())
        << right;
  const std::string longest(247, 'a');
  EXPECT_TRUE(problems_of(system(" unit=\"" + longest + ".service\"", " gateway=\"g\"")).empty());
  for (const std::string& wrong : {std::string("a"), std::string(""), std::string("a.timer"),
                                   std::string("a b.service"), longest + "a.service"})
    EXPECT_EQ(problems_of(system(" unit=\"" + wrong + "\"", " gateway=\"g\"")).size(), 1U) << wrong;
}

TEST(ProgramRules, AreForProgramsOnAGateway) {
  EXPECT_EQ(problems_of(system("", " network=\"n\" unit=\"a.service\"")),
            std::vector<std::string>{
                "t.xml:1: <Subscriber>: attribute unit is for a program on a gateway: remove it"});
  EXPECT_EQ(problems_of(system("", " network=\"n\" group=\"root\"")),
            std::vector<std::string>{
                "t.xml:1: <Subscriber>: attribute group is for a program on a gateway: remove it"});
}

}  // namespace
}  // namespace mlcca::description
