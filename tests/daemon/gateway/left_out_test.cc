// SPDX-License-Identifier: BSD-2-Clause
// Admissions that have no place in the description any more, in a whole gateway among fakes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/model/text.hpp"
#include "tests/daemon/gateway/bench.hpp"

namespace mlcca::test {
namespace {

const std::string kSubject = core::format_subject(kUnlistedSubjects + 1);

class LeftOut : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_FALSE(bench_.start());
    bench_.log().on_event([this](const control::Event& event) { events_.push_back(event); });
  }
  void TearDown() override { bench_.end(); }

  /// A subject that is not described, until nothing may be admitted that is not.
  void admit_and_leave_out() {
    ASSERT_EQ(error(subject()), "");
    bench_.act();
    ASSERT_EQ(bench_.state().admissions().size(), 1U);
    for (core::Network& network : bench_.system.networks) network.unlisted = {};
    reload();
    ASSERT_TRUE(bench_.state().admissions().empty());
    ASSERT_EQ(bench_.recorded(random_).admissions.size(), 1U);
  }
  void reload() {
    static_cast<void>(bench_.ask(control::ReloadRequest{}));
    bench_.reading().finish();
    bench_.act();
  }
  std::string error(decltype(control::Request::body) body) {
    const auto answer = bench_.ask(std::move(body));
    const auto* error = std::get_if<control::Error>(&answer.reply.body);
    return error == nullptr ? "" : error->message;
  }
  static control::Admit newcomer(const std::string& channel) {
    control::Admit request;
    request.channel = channel;
    request.from = "can0";
    request.to = "can1";
    request.publisher = "new";
    request.subscriber = "late";
    request.offered = {{"Period", 50 * kMs, "ns", false}, {"MaxPayload", 8, "bytes", false}};
    return request;
  }
  static control::Admit subject() {
    control::Admit request = newcomer(kSubject);
    request.unlisted = true;
    request.identifiers = {{"can0", 0x70, false}, {"can1", 0x71, false}};
    return request;
  }
  [[nodiscard]] std::vector<control::Event> events(const std::string& kind) const {
    std::vector<control::Event> found;
    std::ranges::copy_if(events_, std::back_inserter(found),
                         [&](const auto& event) { return event.kind == kind; });
    return found;
  }

  std::mt19937 random_;
  Bench bench_{small_system()};
  std::vector<control::Event> events_;
};

TEST_F(LeftOut, AreReleasedByTheirSubject) {
  admit_and_leave_out();
  EXPECT_EQ(error(control::ReleaseRequest{kSubject, 0, ""}), "");
  EXPECT_TRUE(bench_.recorded(random_).admissions.empty());
  EXPECT_NE(error(control::ReleaseRequest{kSubject, 0, ""}), "") << "there is none any more";
}

TEST_F(LeftOut, AreReleasedByTheirSubjectHoweverItIsWritten) {
  admit_and_leave_out();
  EXPECT_NE(error(control::ReleaseRequest{"0x5600000000000002", 0, ""}), "");
  EXPECT_EQ(error(control::ReleaseRequest{"0X5600000000000001", 0, ""}), "");
}

TEST_F(LeftOut, AreReleasedByTheNameOfAChannelThatIsGone) {
  ASSERT_EQ(error(newcomer("c1")), "");
  bench_.act();
  bench_.system.channels.erase(bench_.system.channels.begin() + 1);
  reload();
  ASSERT_TRUE(bench_.state().admissions().empty());
  EXPECT_EQ(error(control::ReleaseRequest{"c1", 0, ""}), "");
  EXPECT_TRUE(bench_.recorded(random_).admissions.empty());
}

TEST_F(LeftOut, AreReleasedTogetherWithThoseThatAreInForce) {
  ASSERT_EQ(error(newcomer("c1")), "");
  auto other = newcomer("c1");
  other.from = "";
  other.publisher = "";
  other.offered = {};
  other.to = "g";
  other.subscriber = "here";
  ASSERT_EQ(error(other), "");
  bench_.act();
  ASSERT_EQ(bench_.state().admissions().size(), 2U);
  bench_.system.networks[1].name = "renamed";
  reload();
  ASSERT_EQ(bench_.state().admissions().size(), 1U);
  EXPECT_EQ(error(control::ReleaseRequest{"c1", 0, ""}), "");
  EXPECT_TRUE(bench_.recorded(random_).admissions.empty());
}

TEST_F(LeftOut, AreNamedWhenTheyAreReleased) {
  admit_and_leave_out();
  ASSERT_EQ(error(control::ReleaseRequest{"", 1, ""}), "");
  const auto released = events("released");
  ASSERT_EQ(released.size(), 1U);
  EXPECT_TRUE(released[0].message.starts_with("admission 1 of " + kSubject + ": released"))
      << released[0].message;
  EXPECT_EQ(released[0].subject, kUnlistedSubjects + 1);
  EXPECT_EQ(released[0].channel, kSubject);
}

TEST_F(LeftOut, AreReportedOnceForEachTimeTheyLoseTheirPlace) {
  const core::System allowing = bench_.system;
  admit_and_leave_out();
  ASSERT_EQ(events("trouble").size(), 1U);
  EXPECT_EQ(events("trouble")[0].subject, kUnlistedSubjects + 1);
  reload();
  EXPECT_EQ(events("trouble").size(), 1U) << "nothing has changed";
  const core::System forbidding = std::exchange(bench_.system, allowing);
  reload();
  ASSERT_EQ(bench_.state().admissions().size(), 1U);
  bench_.system = forbidding;
  reload();
  EXPECT_EQ(events("trouble").size(), 2U);
}

}  // namespace
}  // namespace mlcca::test
