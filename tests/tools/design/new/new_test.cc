// SPDX-License-Identifier: BSD-2-Clause
// Tests of `mlccactl new`, with options and with questions on a terminal.
#include <gtest/gtest.h>

#include <filesystem>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "tests/tools/design/describe/program.hpp"

namespace mlcca {
namespace {

class NewTest : public ::testing::Test {
 protected:
  test::Ran make(std::vector<std::string> options) {
    options.insert(options.begin(), {"new", path_});
    return test::run(std::move(options));
  }
  [[nodiscard]] std::string made() const { return test::content_of(path_); }
  [[nodiscard]] bool has(const std::string& text) const {
    return made().find(text) != std::string::npos;
  }

  test::Folder folder_;
  std::string path_ = folder_.path("robot.xml");
};

TEST_F(NewTest, OptionsMakeADescriptionThatFits) {
  const auto done = make({"--name", "robot", "--gateway", "laptop", "--network",
                          "bus:can:can0:250k", "--network", "lan:udp-multicast:eth0", "--channel",
                          "speed:50ms:8:bus:lan", "--channel", "stop:20ms:4:lan:bus,lan"});
  ASSERT_EQ(done.status, 0) << done.error;
  EXPECT_TRUE(has("<Bus bitrate=\"250000\"/>")) << made();
  EXPECT_TRUE(has("<Identifier form=\"standard\">0x101<")) << made();
  EXPECT_TRUE(has("<Port network=\"lan\"><Interface name=\"eth0\"/></Port>")) << made();
  const auto checked = test::run({"check", path_});
  EXPECT_EQ(checked.status, 0) << checked.out;
  EXPECT_NE(checked.out.find("robot: 2 channels: 2 fit"), std::string::npos) << checked.out;
}

TEST_F(NewTest, TheQueueOfThePortHoldsWhatCrosses) {
  std::vector<std::string> options{"--gateway",  "g",         "--network",
                                   "a:can:can0", "--network", "b:can:can1"};
  for (int n = 1; n <= 12; ++n) {
    options.emplace_back("--channel");
    options.push_back("c" + std::to_string(n) + ":100ms:8:a:b");
  }
  ASSERT_EQ(make(options).status, 0);
  EXPECT_TRUE(has("<Port network=\"b\" queue-length=\"12\"><Interface name=\"can1\"/>")) << made();
  const auto checked = test::run({"check", path_});
  EXPECT_EQ(checked.status, 0) << checked.out;
}

TEST_F(NewTest, WithoutANameTheGatewayIsCalledGateway) {
  const auto done = make({"--network", "bus:can:can0", "--network", "lan:udp-multicast:eth0",
                          "--channel", "speed:50ms:8:bus:lan"});
  ASSERT_EQ(done.status, 0) << done.error;
  EXPECT_EQ(done.error, "note: no --gateway: it is called gateway\n");
  EXPECT_TRUE(has("<Gateway name=\"gateway\">")) << made();
  EXPECT_TRUE(has("<Port network=\"bus\"><Interface name=\"can0\"/></Port>")) << made();
  const auto checked = test::run({"check", path_});
  EXPECT_EQ(checked.status, 0) << checked.out;
  EXPECT_NE(checked.out.find("1 channel: 1 fit"), std::string::npos) << checked.out;
  const auto named = test::run(
      {"new", folder_.path("named.xml"), "--gateway", "g", "--network", "bus:can:can0", "--json"});
  EXPECT_NE(named.out.find(R"("gateway":"g","channels":0,"notes":["no --channel: the gateway)"),
            std::string::npos)
      << named.out;
}

TEST_F(NewTest, AMeshIsDecidedAtRunTime) {
  ASSERT_EQ(make({"--gateway", "laptop", "--network", "bus:can:can0", "--network", "air:mesh:mesh0",
                  "--channel", "speed:50ms:8:bus:air"})
                .status,
            0);
  const auto checked = test::run({"check", path_});
  EXPECT_NE(checked.out.find("1 decided at run time"), std::string::npos) << checked.out;
}

TEST_F(NewTest, AFileIsNotOverwritten) {
  folder_.write("robot.xml", "mine");
  EXPECT_EQ(make({"--network", "bus:can:can0"}).status, 3);
  EXPECT_EQ(made(), "mine");
}

TEST_F(NewTest, ADryRunWritesNothing) {
  const auto done = make({"--network", "bus:can:can0", "--dry-run"});
  EXPECT_NE(done.out.find("<System name=\"system\">"), std::string::npos);
  EXPECT_EQ(made(), "");
}

TEST_F(NewTest, TheFileCanBeStandardOutput) {
  for (const char* const file : {"-", "/dev/stdout"}) {
    const auto done = test::run({"new", file, "--network", "bus:can:can0"});
    EXPECT_EQ(done.status, 0) << done.error;
    EXPECT_TRUE(done.out.starts_with("<?xml")) << done.out;
  }
  EXPECT_FALSE(std::filesystem::exists("-"));
}

struct NewRow {
  const char* name;
  std::vector<std::string> options;
  const char* error;  ///< a part of the error
};
void PrintTo(const NewRow& row, std::ostream* out) { *out << row.name; }
struct NewWrongTest : NewTest, ::testing::WithParamInterface<NewRow> {};

TEST_P(NewWrongTest, IsRefusedWithWhatWouldBeRight) {
  const auto done = make(GetParam().options);
  EXPECT_EQ(done.status, 2);
  EXPECT_NE(done.error.find(GetParam().error), std::string::npos) << done.error;
  EXPECT_EQ(made(), "");
}

INSTANTIATE_TEST_SUITE_P(
    Options, NewWrongTest,
    ::testing::Values(
        NewRow{"Nothing", {}, "say what there is"},
        NewRow{"NoNetwork", {"--gateway", "g"}, "--network: a system has at least one"},
        NewRow{
            "AChannelAlone", {"--channel", "c:1s:8:a:a"}, "--network: a system has at least one"},
        NewRow{"NameOfTheGateway",
               {"--network", "gateway:can:x"},
               "'gateway': is the name of the gateway: give one of the two another name"},
        NewRow{"Kind",
               {"--network", "a:bus:can0"},
               "'bus': must be can, udp-multicast, udp-broadcast or mesh"},
        NewRow{"Parts", {"--network", "a"}, "must be NAME:KIND:INTERFACE"},
        NewRow{"Name", {"--network", "0:can:can0"}, "a letter, then up to 62 letters"},
        NewRow{"Interface", {"--network", "a:can:<x>"}, "as the kernel names interfaces"},
        NewRow{"Twice", {"--network", "a:can:x", "--network", "a:can:y"}, "the name is taken"},
        NewRow{"Rate", {"--network", "a:can:x:2M"}, "a CAN bus has at most 1 Mbit/s"},
        NewRow{"Unknown",
               {"--network", "a:can:x", "--channel", "c:1s:8:b:a"},
               "'b': there is no such network; there are a"},
        NewRow{"Period", {"--network", "a:can:x", "--channel", "c:1:8:a:a"}, "needs a unit"},
        NewRow{"Long", {"--network", "a:can:x", "--channel", "c:1s:9:a:a"}, "at most 8 bytes"}),
    [](const auto& row) { return row.param.name; });

TEST_F(NewTest, QuestionsMakeTheSame) {
  test::OnTerminal terminal({"new", path_});
  const auto answer = [&](const std::string& question, const std::string& text) {
    terminal.await(question);
    terminal.type(text + "\n");
  };
  answer("Gateway", "laptop");
  answer("Network, its name", "0");
  answer("a letter, then up to 62 letters", "bus");
  answer("kind of bus: can, udp-multicast, udp-broadcast or mesh [can]", "kan");
  answer("must be can, udp-multicast, udp-broadcast or mesh", "");
  answer("interface of bus at laptop [can0]", "can1");
  answer("bit rate of bus [500k]", "2M");
  answer("a CAN bus has at most 1 Mbit/s", "250k");
  answer("Network, its name [no more]", "lan");
  answer("kind of lan", "udp-multicast");
  answer("interface of lan at laptop [eth0]", "can1");
  answer("is the interface of bus", "");
  answer("Network, its name [no more]", "");
  answer("Channel, its name [no more]", "speed");
  answer("Period of speed, the time from one event to the next [50ms]", "10");
  answer("needs a unit", "10ms");
  answer("published on, of bus, lan [bus]", "lam");
  answer("there is no such network", "lan");
  answer("subscribed on, with commas between several [bus]", "bus,lan");
  answer("bytes of an event [8]", "9");
  answer("at most 8 bytes", "4");
  answer("Channel, its name [no more]", "");
  answer("Write", "yes");
  EXPECT_EQ(terminal.finish(), 0) << terminal.screen();
  test::Folder other;
  const std::string same = other.path("same.xml");
  ASSERT_EQ(
      test::run({"new", same, "--gateway", "laptop", "--network", "bus:can:can1:250k", "--network",
                 "lan:udp-multicast:eth0", "--channel", "speed:10ms:4:lan:bus,lan"})
          .status,
      0);
  const auto but_subject = [](std::string text) {
    const auto begin = text.find("<SubjectUID>");
    return text.erase(begin, text.find("</SubjectUID>") - begin);
  };
  EXPECT_EQ(but_subject(made()), but_subject(test::content_of(same)));
}

TEST_F(NewTest, WhatIsWrittenAsForAnOptionIsNoAnswer) {
  test::OnTerminal terminal({"new", path_});
  terminal.await("Gateway");
  terminal.type("\n");
  terminal.await("Network, its name: ");
  terminal.type("\n");
  terminal.await("at least one is needed");
  terminal.type("bus:can:can0\n");
  terminal.await("'bus:can:can0': one thing at a time");
  terminal.type("\x04");
  EXPECT_EQ(terminal.finish(), 1) << terminal.screen();
  EXPECT_EQ(made(), "");
}

TEST_F(NewTest, TheEndOfTheInputWritesNothing) {
  test::OnTerminal terminal({"new", path_});
  terminal.await("Gateway");
  terminal.type("\x04");
  EXPECT_EQ(terminal.finish(), 1) << terminal.screen();
  EXPECT_EQ(made(), "");
}

}  // namespace
}  // namespace mlcca
