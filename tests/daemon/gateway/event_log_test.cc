// SPDX-License-Identifier: BSD-2-Clause
// Who learns of an event, and who is named as its cause.
#include "daemon/gateway/event_log.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "daemon/store/history.hpp"
#include "tests/daemon/store/worlds.hpp"

namespace mlcca {
namespace {

class EventLogTest : public ::testing::Test {
 protected:
  EventLogTest() {
    log_.on_event([this](const control::Event& event) { published_.push_back(event); });
    log_.keep_in(history_);
  }
  std::vector<store::Decision> kept() {
    history_.flush(1);
    const auto rows = history_.query({});
    EXPECT_TRUE(rows);
    return rows ? *rows : std::vector<store::Decision>{};
  }

  store::test::Folder folder_;
  store::History history_ = store::History::open(folder_.path());
  EventLog log_{SystemLog::to_stderr()};
  std::vector<control::Event> published_;
};

TEST_F(EventLogTest, ADeliveryGoesToWhoListensAndToTheHistory) {
  log_.warning(Kind::withdrawn, "no links",
               {.subject = 7, .channel = "stop", .network = "mesh", .from = "bus"});
  ASSERT_EQ(published_.size(), 1U);
  EXPECT_EQ(published_[0].kind, "withdrawn");
  EXPECT_EQ(published_[0].channel, "stop");
  EXPECT_EQ(published_[0].message, "no links");
  const auto rows = kept();
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].kind, "withdrawn");
  EXPECT_EQ(rows[0].subject, 7U);
  EXPECT_EQ(rows[0].from, "bus");
  EXPECT_EQ(rows[0].to, "mesh");
  EXPECT_EQ(rows[0].network, "");
  EXPECT_EQ(log_.rows(), 1U);
}

TEST_F(EventLogTest, OfANetworkAloneTheHistoryHasNoDelivery) {
  log_.info(Kind::interface, "can0 is bus", {.network = "bus"});
  const auto rows = kept();
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].network, "bus");
  EXPECT_EQ(rows[0].to, "");
}

TEST_F(EventLogTest, DropsAreReportedAndNotKept) {
  log_.warning(Kind::dropped, "3 frames");
  EXPECT_EQ(published_.size(), 1U);
  EXPECT_TRUE(kept().empty());
  EXPECT_EQ(log_.rows(), 0U);
}

TEST_F(EventLogTest, TheClientThatAskedIsNamedAsLongAsItsRequestLasts) {
  {
    const EventLog::Acting client(log_, control::Actor{.uid = 1000, .user = "alice", .pid = 42});
    log_.notice(Kind::released, "by request");
    {
      const EventLog::Acting no_actor(log_, std::nullopt);
      log_.notice(Kind::released, "by itself");
    }
    log_.notice(Kind::released, "by request again");
  }
  log_.notice(Kind::released, "afterwards");
  ASSERT_EQ(published_.size(), 4U);
  EXPECT_EQ(published_[0].message, "by request (by alice, uid 1000, process 42)");
  EXPECT_EQ(published_[1].message, "by itself");
  EXPECT_FALSE(published_[1].client);
  ASSERT_TRUE(published_[2].client);
  EXPECT_EQ(published_[2].client->uid, 1000U);
  EXPECT_FALSE(published_[3].client);
}

TEST_F(EventLogTest, RowsThatComeLaterAreCountedNow) {
  log_.add_rows(5);
  log_.error(Kind::problem, "one more");
  EXPECT_EQ(log_.rows(), 6U);
}

}  // namespace
}  // namespace mlcca
