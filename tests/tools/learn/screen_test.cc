// SPDX-License-Identifier: BSD-2-Clause
// What candump shows on a screen, as a recording, and recordings without a frame.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tests/tools/design/describe/program.hpp"
#include "tests/tools/learn/traffic.hpp"
#include "tools/learn/recording.hpp"

namespace mlcca::learn {
namespace {

using mlcca::test::Folder;
using mlcca::test::Ran;
using mlcca::test::run;
using test::Sent;

struct ReadBack {
  std::vector<Sent> sent;
  std::vector<std::string> names;
  std::uint64_t left = 0;
  std::string first;
  std::string error;
  std::uint64_t errors = 0;  ///< error frames
};

ReadBack read(const std::string& text) {
  ReadBack out;
  Interfaces interfaces;
  const auto left = read_recording(
      {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()},  // NOLINT
      "screen", interfaces, [&](const Frame& f) {
        out.sent.push_back(
            {f.ns, f.interface, f.id, {f.data.begin(), f.data.end()}, f.fd, f.local});
      });
  out.names = interfaces.names();
  if (!left) {
    out.error = left.error().text;
    return out;
  }
  out.left = left->lines;
  out.errors = left->errors;
  out.first = left->first;
  return out;
}

TEST(Screen, LinesWithTimesAreFrames) {
  const auto is = read(
      "\n (1436509052.249713)  can0       123   [2]  11 22\n"
      " (1436509052.249714)  vcan1  18FEF100   [0]  \n"
      " (1436509052.250000)  can0       123  [12]  AA BB 00 00 00 00 00 00 00 00 00 0c\r\n"
      " (1436509053.000001)  can0  TX - -  7FF   [8]  remote request\n"
      " (1436509053.000002)  can0  RX - -  7FE   [0]  remote request\n"
      " (1436509054.000001)  can0  20000080   [8]  00 00 00 00 00 00 00 00   ERRORFRAME\n"
      " (1436509055.000001)  can0       001   [1]  41   'A'\n");
  ASSERT_EQ(is.error, "");
  EXPECT_EQ(is.left, 0U) << is.first;
  EXPECT_EQ(is.names, (std::vector<std::string>{"can0", "vcan1"}));
  ASSERT_EQ(is.sent.size(), 6U) << "an error frame is none";
  EXPECT_EQ(is.errors, 1U);
  EXPECT_EQ(is.sent[0].ns, 1'436'509'052'249'713'000U);
  EXPECT_EQ(is.sent[0].id, 0x123U);
  EXPECT_EQ(is.sent[0].data, (std::vector<std::uint8_t>{0x11, 0x22}));
  EXPECT_EQ(is.sent[1].id, 0x18fef100U | kExtended);
  EXPECT_EQ(is.sent[1].interface, 1U);
  EXPECT_TRUE(is.sent[2].fd);
  EXPECT_EQ(is.sent[2].data.size(), 12U);
  EXPECT_EQ(is.sent[3].id, 0x7ffU | kRemote);
  EXPECT_TRUE(is.sent[3].local);
  EXPECT_EQ(is.sent[4].id, 0x7feU | kRemote);
  EXPECT_FALSE(is.sent[4].local);
  EXPECT_EQ(is.sent[5].data, std::vector<std::uint8_t>{0x41});
}

TEST(Screen, TimesMayCountFromTheBeginning) {
  std::string text;
  for (unsigned i = 0; i < 100; ++i)
    text += " (0" + std::to_string(i / 10 + 10) + "." + std::to_string(i % 10) +
            "00000)  can0  123   [1]  00\n";
  const auto is = read(text);
  ASSERT_EQ(is.error, "");
  EXPECT_EQ(is.sent.size(), 100U);
  EXPECT_EQ(is.sent[1].ns, 10'100'000'000U);
}

TEST(Screen, LinesThatAreNoFramesArePassedOver) {
  const auto is = read(
      " (1.0)  can0  123   [1]  11\n (1.1)  can0  123   [9]  11\n (1.2)  can0  12   [1]  11\n"
      " (1.3)  can0  123   [2]  11\n (1.4)  can0  123   [1]  1G\n (1.5)  can0\n (x)  can0\n"
      " (1.6)  can0  FFF   [0]\n");
  EXPECT_EQ(is.sent.size(), 1U);
  EXPECT_EQ(is.left, 7U);
  EXPECT_TRUE(is.first.starts_with("line 2: ' (1.1)  can0")) << is.first;
}

TEST(Screen, TimesThatSayNothingAreRefusedWithWhatIsRight) {
  std::string deltas;
  for (unsigned i = 0; i < 50; ++i)
    deltas += " (000.0" + std::to_string(10000 + i * 7919 % 100) + ")  can0  123   [1]  00\n";
  const std::pair<std::string, const char*> cases[] = {
      {deltas, "with the times between frames (-td)"},
      {" (2023-11-14 22:13:20.123456)  can0  123   [1]  00\n", "with dates (-tA)"},
      {"  can0       123   [8]  11 22 33 44 55 66 77 88\n", "without time stamps"}};
  for (const auto& [text, says] : cases) {
    const auto is = read(text);
    EXPECT_TRUE(is.error.contains(says)) << is.error;
    EXPECT_TRUE(is.error.contains("record with candump -l")) << is.error;
  }
}

TEST(Screen, ALearnedScreenIsADraft) {
  const Folder folder;
  std::string text;
  for (unsigned i = 0; i < 100; ++i)
    text += " (17000000" + std::to_string(i / 10 + 10) + "." + std::to_string(i % 10) +
            "00000)  can0       123   [8]  11 22 33 44 55 66 77 88\n";
  const Ran ran = run({"learn", folder.write("screen.txt", text)});
  EXPECT_EQ(ran.status, 0) << ran.error;
  EXPECT_TRUE(ran.out.contains(R"(<Attributes period="100ms")")) << ran.out;
}

TEST(Screen, ARecordingWithoutAFrameIsRefusedAndWritesNothing) {
  const Folder folder;
  const auto path = folder.path("draft.xml");
  for (const char* text : {"(1.0) can0 12#11\n(1.1) can0 13#11\n",
                           "(1.0) can0 20000080#0000000000000000\n(1.1) can0 13#11\n"}) {
    const Ran ran = run({"learn", folder.write("empty.log", text), "--output", path});
    EXPECT_EQ(ran.status, 2) << ran.out;
    EXPECT_TRUE(ran.error.contains("empty.log: no frame was recognised in it")) << ran.error;
    EXPECT_NE(::access(path.c_str(), F_OK), 0);
  }
}

}  // namespace
}  // namespace mlcca::learn
