// SPDX-License-Identifier: BSD-2-Clause
// A broker that keeps what it has dealt: over restarts, a full disk, and a file that is not its
// own.
#include "relay/famouso/bus_broker.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "base/big_endian.hpp"
#include "tests/control/server.hpp"
#include "tests/relay/famouso/node_client.hpp"

namespace mlcca::relay {
namespace {

constexpr Uid kOwn{'b', 'r', 'o', 'k', 'e', 'r', 0, 1};
constexpr SubjectId kDistance = 0x44697374616e6365;
constexpr SubjectId kSwitch = 0x5377697463685f5f;

Frame tag_request(SubjectId subject, std::uint32_t node = 0x7d) {
  return {.id = kNormalPriority | node << kNodeShift | kTagRequest,
          .length = 8,
          .data = big_endian(subject)};
}

class BusBrokerTest : public ::testing::Test {
 protected:
  Result<BusBroker> make(std::vector<TagBroker::Dealt> stated = {}) {
    auto file = DealtFile::open(path_);
    if (!file) return std::unexpected(file.error());
    return BusBroker::make(kOwn, std::move(*file), stated,
                           [this](const std::string& text) { said_.push_back(text); });
  }
  /// 0: no answer.
  static unsigned tag_from(BusBroker& broker, SubjectId subject, std::uint64_t now = 0) {
    const auto frames = broker.take(tag_request(subject), now);
    if (frames.size() != 2) return 0;
    return unsigned{frames[0].data[2]} << 8U | frames[0].data[3];
  }
  [[nodiscard]] std::string content() const {
    std::ifstream file(path_);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void write(const std::string& text) const { std::ofstream(path_) << text; }

  test::TempDir folder_;
  const std::string path_ = folder_.path("can0");
  std::vector<std::string> said_;
};

TEST_F(BusBrokerTest, ATagIsItsSubjectsOverRestarts) {
  {
    auto broker = make();
    ASSERT_TRUE(broker) << broker.error().text;
    EXPECT_EQ(tag_from(*broker, kDistance), 0x3fffU);
    EXPECT_EQ(tag_from(*broker, kSwitch), 0x3ffeU);
  }
  EXPECT_EQ(content(),
            "node 0x7e 0x62726f6b65720001\n"
            "tag 0x3fff 0x44697374616e6365\n"
            "tag 0x3ffe 0x5377697463685f5f\n");
  auto again = make();
  ASSERT_TRUE(again);
  EXPECT_EQ(tag_from(*again, kSwitch), 0x3ffeU);
  EXPECT_EQ(tag_from(*again, 1), 0x3ffdU);
  EXPECT_EQ(tag_from(*again, kDistance), 0x3fffU);
}

/// Whoever asks asks again without end.
TEST_F(BusBrokerTest, WhoGetsNoTagOrNumberIsSaidOnce) {
  std::string text;
  for (unsigned node = 0; node <= kHighestNode; ++node)
    text += fmt::format("node {:#x} {:#018x}\n", node, 0x6e6f646530303030U + node);
  for (unsigned tag = kLowestTag; tag <= kHighestTag; ++tag)
    text += fmt::format("tag {:#x} {:#018x}\n", tag, 0x7461675f30303030U + tag);
  write(text);
  auto broker = make();
  ASSERT_TRUE(broker) << broker.error().text;
  said_.clear();
  const std::string again =
      " are assigned. To assign them again, stop all nodes of the bus and this "
      "program, and remove " +
      path_;
  for (const SubjectId subject : {kDistance, kSwitch, kDistance})
    EXPECT_EQ(tag_from(*broker, subject), 0U);
  EXPECT_EQ(said_, std::vector<std::string>{"0x44697374616e6365 gets no tag, since all" + again});
  said_.clear();
  for (int i = 0; i < 2; ++i) {
    NodeClient node(big_endian(kDistance));
    std::vector<Frame> answers = broker->take(node.start(0), 0);
    while (answers.size() == 1)
      if (const auto next = node.take(answers.front(), 0)) answers = broker->take(*next, 0);
    EXPECT_FALSE(node.number());
  }
  EXPECT_EQ(said_,
            std::vector<std::string>{"node 0x44697374616e6365 gets no number, since all" + again});
}

TEST_F(BusBrokerTest, ASubjectOfTheDescriptionHasItsTag) {
  auto broker = make({{kSwitch, 0x3fff}, {7, 0x65}});
  ASSERT_TRUE(broker) << broker.error().text;
  EXPECT_EQ(tag_from(*broker, kDistance), 0x3ffeU);
  EXPECT_EQ(tag_from(*broker, kSwitch), 0x3fffU);
  EXPECT_EQ(tag_from(*broker, 7), 0x65U);
  // The same is stated again; and otherwise.
  EXPECT_TRUE(make({{kSwitch, 0x3fff}}));
  for (const TagBroker::Dealt& other : {TagBroker::Dealt{kSwitch, 0x3000}, {9, 0x3ffe}}) {
    const auto refused = make({other});
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().text.find("cannot be dealt"), std::string::npos);
  }
}

TEST_F(BusBrokerTest, WhatIsNotWrittenWholeWasNotAnswered) {
  write("tag 0x3fff 0x44697374616e6365\ntag 0x3ffe 0x53776");
  auto broker = make();
  ASSERT_TRUE(broker) << broker.error().text;
  EXPECT_EQ(tag_from(*broker, kSwitch), 0x3ffeU);
  EXPECT_EQ(content(),
            "tag 0x3fff 0x44697374616e6365\n"
            "node 0x7e 0x62726f6b65720001\n"
            "tag 0x3ffe 0x5377697463685f5f\n");
}

TEST_F(BusBrokerTest, AFileThatIsNotItsOwnIsRefusedWithTheLine) {
  for (const auto& [text, why] : std::vector<std::pair<std::string, std::string>>{
           {"tag 0x3fff 0x1\nwhatever\n", ":2: 'whatever' must be such as"},
           {"tag 0x4000 0x1\n", ":1: "},
           {"node 0x7f 0x1\n", ":1: "},
           {"tag 0x3fff 0x0\n", ":1: "},
           {"tag 0x3fff\n", ":1: "},
           {"etag 0x3fff 0x1\n", ":1: "},
           {"tag 0x3fff 0x1\ntag 0x3fff 0x2\n", ":2: 0x3fff was dealt before"},
           {std::string(2 << 20, 'x'), "too large"}}) {
    write(text);
    const auto broker = make();
    ASSERT_FALSE(broker) << text.substr(0, 60);
    EXPECT_NE(broker.error().text.find(why), std::string::npos) << broker.error().text;
  }
}

/// Files of this process have so many bytes at most.
class Full {
 public:
  explicit Full(rlim_t bytes) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    former_ = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit now{.rlim_cur = bytes, .rlim_max = before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &now);
  }
  ~Full() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, former_);
  }
  Full(const Full&) = delete;
  Full& operator=(const Full&) = delete;

 private:
  rlimit before_{};
  void (*former_)(int) = nullptr;
};

TEST_F(BusBrokerTest, WhatCannotBeWrittenDownIsNotAnswered) {
  auto broker = make();
  ASSERT_TRUE(broker);
  const std::string before = content();
  said_.clear();
  {
    const Full disk(before.size() + 5);
    EXPECT_EQ(tag_from(*broker, kDistance), 0U);
    EXPECT_EQ(tag_from(*broker, kSwitch), 0U);
    EXPECT_EQ(said_.size(), 1U) << "said once";
    EXPECT_EQ(content(), before);
  }
  EXPECT_EQ(tag_from(*broker, kSwitch), 0x3ffeU);
  EXPECT_EQ(tag_from(*broker, kDistance), 0x3fffU);
  EXPECT_EQ(content(), before + "tag 0x3fff 0x44697374616e6365\ntag 0x3ffe 0x5377697463685f5f\n");
}

TEST_F(BusBrokerTest, SoManyRequestsASecondAreAnsweredAndNoMore) {
  auto broker = make();
  ASSERT_TRUE(broker);
  constexpr std::uint64_t second = 1'000'000'000;
  for (std::uint64_t i = 0; i < BusBroker::kMostPerSecond; ++i)
    EXPECT_NE(tag_from(*broker, kDistance, second), 0U);
  EXPECT_EQ(tag_from(*broker, kDistance, second), 0U);
  EXPECT_EQ(tag_from(*broker, kDistance, 2 * second - 1), 0U);
  EXPECT_NE(tag_from(*broker, kDistance, 2 * second), 0U);
}

TEST_F(BusBrokerTest, ANodeKeepsItsNumberOverRestarts) {
  const Uid uid{'n', 'o', 'd', 'e', 0, 0, 0, 1};
  for (int start = 0; start < 2; ++start) {
    auto broker = make();
    ASSERT_TRUE(broker);
    NodeClient node(uid);
    std::vector<Frame> answers = broker->take(node.start(0), 0);
    for (int i = 0; i < 40 && !node.number(); ++i) {
      ASSERT_EQ(answers.size(), 1U);
      const auto next = node.take(answers.front(), 0);
      if (next) answers = broker->take(*next, 0);
    }
    EXPECT_EQ(node.number(), 0x7d);
  }
}

}  // namespace
}  // namespace mlcca::relay
