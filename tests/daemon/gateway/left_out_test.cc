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

/// Where an operator finds them, each once.
TEST_F(LeftOut, AreInStatusChannelsAndExplain) {
  admit_and_leave_out();
  const auto status = bench_.ask(control::StatusRequest{});
  std::vector<std::string> of_it;
  for (const auto& reason : std::get<control::Status>(status.reply.body).health.reasons)
    if (reason.contains("admission 1")) of_it.push_back(reason);
  ASSERT_EQ(of_it.size(), 1U);
  EXPECT_TRUE(of_it[0].starts_with("admission 1 of " + kSubject + " is left out: "));
  EXPECT_EQ(of_it[0].find("admission 1", 1), std::string::npos) << of_it[0];
  const control::LeftOutAdmission expected{
      1, kSubject,
      of_it[0].substr(std::string("admission 1 of  is left out: ").size() + kSubject.size())};
  const auto all = bench_.ask(control::ChannelsRequest{});
  ASSERT_TRUE(all.slices);
  const auto slice = all.slices();
  ASSERT_TRUE(slice && !slice->more);
  EXPECT_EQ(std::get<control::Channels>(slice->body).admissions_left_out, std::vector{expected});
  const auto one = bench_.ask(control::ExplainRequest{kSubject});
  ASSERT_TRUE(std::holds_alternative<control::Channels>(one.reply.body)) << "it is not described";
  EXPECT_EQ(std::get<control::Channels>(one.reply.body).admissions_left_out, std::vector{expected});
  const auto other = bench_.ask(control::ExplainRequest{"c0"});
  EXPECT_TRUE(std::get<control::Channels>(other.reply.body).admissions_left_out.empty());
  EXPECT_NE(error(control::ExplainRequest{"c9"}), "");
}

TEST_F(LeftOut, AreRemovedWithTheirNumberAndStayRecorded) {
  admit_and_leave_out();
  const auto removed = events("removed");
  ASSERT_EQ(removed.size(), 1U);
  EXPECT_TRUE(removed[0].message.contains(
      "is removed: the description has no place for admission 1, which is left out"))
      << removed[0].message;
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
  ASSERT_EQ(events("problem").size(), 1U);
  EXPECT_EQ(events("problem")[0].subject, kUnlistedSubjects + 1);
  reload();
  EXPECT_EQ(events("problem").size(), 1U) << "nothing has changed";
  const core::System forbidding = std::exchange(bench_.system, allowing);
  reload();
  ASSERT_EQ(bench_.state().admissions().size(), 1U);
  bench_.system = forbidding;
  reload();
  EXPECT_EQ(events("problem").size(), 2U);
}

}  // namespace
}  // namespace mlcca::test
