// SPDX-License-Identifier: BSD-2-Clause
// mlccactl describe on a real pseudo-terminal: questions and answers.
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <string>

#include "tests/tools/design/describe/program.hpp"

namespace mlcca::test {
namespace {

constexpr const char* kChannel =
    "<EventChannel name=\"switch\">\n"
    "  <SubjectUID>0x17</SubjectUID>\n"
    "  <!-- kept -->\n"
    "  <Attributes>\n"
    "    <Attribute><Name>Omission</Name><Value>2</Value></Attribute>\n"
    "  </Attributes>\n"
    "</EventChannel>\n";

/// Answers with Enter up to, not including, the question that starts with `title`.
void enter_until(OnTerminal& terminal, const std::string& title) {
  for (const char* question :
       {"Subject,", "Name,", "Description,", "Safe side", "Latency:", "Jitter:", "Deadline:",
        "Period:", "Bandwidth:", "PacketLoss:", "Omission:", "MaxPayload:", "Another"}) {
    if (title == question) return;
    terminal.await(question);
    terminal.await("]: ");
    terminal.type("\n");
  }
}

TEST(DescribeOnTerminalTest, AsksForEachFieldOfANewChannel) {
  const Folder folder;
  const auto file = folder.path("c.xml");
  OnTerminal terminal({"describe", file});
  terminal.await("a new event channel");
  const std::pair<const char*, const char*> answers[] = {{"Subject,", "0x17"},
                                                         {"Name,", "switch"},
                                                         {"Description,", "stop"},
                                                         {"Safe side", "drop"},
                                                         {"Latency:", ""},
                                                         {"Jitter:", ""},
                                                         {"Deadline:", ""},
                                                         {"Period:", "50 ms"},
                                                         {"Bandwidth:", ""},
                                                         {"PacketLoss:", ""},
                                                         {"Omission:", "2"},
                                                         {"MaxPayload:", "8"},
                                                         {"Another", "Temperature=21.5 K"},
                                                         {"Another", ""}};
  for (const auto& [question, answer] : answers) {
    terminal.await(question);
    terminal.await("]: ");
    terminal.type(std::string(answer) + "\n");
  }
  terminal.await("Period: 50 ms");
  terminal.await("Write ");
  terminal.type("\n");
  EXPECT_EQ(terminal.finish(), 0) << terminal.screen();
  EXPECT_EQ(content_of(file),
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
            "<EventChannel name=\"switch\" safe-side=\"drop\">\n"
            "  <SubjectUID>0x17</SubjectUID>\n"
            "  <Description>stop</Description>\n"
            "  <Attributes period=\"50ms\" omission=\"2\" maxPayload=\"8\">\n"
            "    <Attribute>\n"
            "      <Name>Temperature</Name>\n"
            "      <Dimension><SIUnit><Kelvins>1</Kelvins></SIUnit></Dimension>\n"
            "      <Value>21.5</Value>\n"
            "    </Attribute>\n"
            "  </Attributes>\n"
            "</EventChannel>\n");
}

TEST(DescribeOnTerminalTest, EnterKeepsEverything) {
  const Folder folder;
  const auto file = folder.write("c.xml", kChannel);
  OnTerminal terminal({"describe", file});
  terminal.await("event channel switch");
  enter_until(terminal, "");
  terminal.await("nothing to change");
  EXPECT_EQ(terminal.finish(), 0);
  EXPECT_EQ(content_of(file), kChannel);
}

TEST(DescribeOnTerminalTest, AWrongAnswerIsExplainedAndAskedForAgain) {
  const Folder folder;
  const auto file = folder.write("c.xml", kChannel);
  OnTerminal terminal({"describe", file});
  enter_until(terminal, "Omission:");
  terminal.await("Omission:");
  terminal.await("[2]: ");
  terminal.type("two\n");
  terminal.await("must be a number");
  terminal.await("Omission:");
  terminal.type("3\n");
  terminal.await("MaxPayload:");
  terminal.type("\n");
  terminal.await("Another");
  terminal.type("\n");
  terminal.await("Omission: 2 -> 3");
  terminal.type("yes\n");
  EXPECT_EQ(terminal.finish(), 0);
  auto expected = std::string(kChannel);
  expected.replace(expected.find("<Value>2"), 8, "<Value>3");
  EXPECT_EQ(content_of(file), expected);
}

TEST(DescribeOnTerminalTest, ADashRemoves) {
  const Folder folder;
  const auto file = folder.write("c.xml", kChannel);
  OnTerminal terminal({"describe", file});
  enter_until(terminal, "Omission:");
  terminal.await("Omission:");
  terminal.type("-\n");
  terminal.await("MaxPayload:");
  terminal.type("\n");
  terminal.await("Another");
  terminal.type("\n");
  terminal.await("Omission: removed, was 2");
  terminal.type("yes\n");
  EXPECT_EQ(terminal.finish(), 0);
  EXPECT_FALSE(content_of(file).contains("Omission"));
  EXPECT_TRUE(content_of(file).contains("<!-- kept -->"));
}

TEST(DescribeOnTerminalTest, EndOfInputLeavesTheFileAlone) {
  const Folder folder;
  const auto file = folder.write("c.xml", kChannel);
  OnTerminal terminal({"describe", file});
  terminal.await("Subject,");
  terminal.type("0x18\n");
  terminal.await("Name,");
  terminal.type("\x04");
  terminal.await("nothing was written");
  EXPECT_EQ(terminal.finish(), 1);
  EXPECT_EQ(content_of(file), kChannel);
}

TEST(DescribeOnTerminalTest, InterruptLeavesNoFile) {
  const Folder folder;
  const auto file = folder.path("c.xml");
  OnTerminal terminal({"describe", file});
  terminal.await("Subject,");
  terminal.type("0x18\n");
  terminal.await("Name,");
  terminal.type("\x03");
  EXPECT_EQ(terminal.finish(), -SIGINT);
  EXPECT_NE(::access(file.c_str(), F_OK), 0);
}

TEST(DescribeOnTerminalTest, NoAtTheEndWritesNothing) {
  const Folder folder;
  const auto file = folder.write("c.xml", kChannel);
  OnTerminal terminal({"describe", file});
  terminal.await("Subject,");
  terminal.type("0x18\n");
  enter_until(terminal, "Subject,");
  for (const char* question :
       {"Name,", "Description,", "Safe side", "Latency:", "Jitter:", "Deadline:", "Period:",
        "Bandwidth:", "PacketLoss:", "Omission:", "MaxPayload:", "Another"}) {
    terminal.await(question);
    terminal.await("]: ");
    terminal.type("\n");
  }
  terminal.await("Write ");
  terminal.type("no\n");
  EXPECT_EQ(terminal.finish(), 1);
  EXPECT_EQ(content_of(file), kChannel);
}

}  // namespace
}  // namespace mlcca::test
