// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/rounds.hpp"

#include <gtest/gtest.h>

#include <string>

namespace mlcca {
namespace {

/// Each piece of a job takes a millionth of what it is asked to, and writes its letter.
class RoundsTest : public ::testing::Test {
 protected:
  void add(char letter, std::size_t pieces, std::uint64_t ns) {
    rounds_.add([this, letter, pieces, ns, done = std::size_t{0}]() mutable {
      now_ += ns;
      log_ += letter;
      done = (done + 1) % pieces;
      return done != 0;
    });
  }
  /// What a turn does.
  std::string turn() {
    log_.clear();
    rounds_.turn();
    return log_;
  }

  std::uint64_t now_ = 0;
  std::string log_;
  Rounds rounds_{[this] { return now_; }};
};

TEST_F(RoundsTest, DoesNothingBeforeItBegins) {
  EXPECT_FALSE(rounds_.under_way()) << "there is no job";
  rounds_.begin();
  EXPECT_EQ(turn(), "");
}

TEST_F(RoundsTest, ShortJobsAreDoneInOneTurnInTheirOrder) {
  add('a', 2, 1000);
  add('b', 1, 1000);
  rounds_.begin();
  EXPECT_EQ(turn(), "aab");
  EXPECT_FALSE(rounds_.under_way());
  EXPECT_EQ(turn(), "") << "until the next round";
  rounds_.begin();
  EXPECT_EQ(turn(), "aab");
}

TEST_F(RoundsTest, ATurnEndsWithThePieceInWhichItsTimeHasPassed) {
  add('a', 5, Rounds::kTurn / 2);
  add('b', 1, 1);
  rounds_.begin();
  EXPECT_EQ(turn(), "aa");
  EXPECT_EQ(turn(), "aa");
  EXPECT_TRUE(rounds_.under_way());
  EXPECT_EQ(turn(), "ab");
  EXPECT_FALSE(rounds_.under_way());
}

TEST_F(RoundsTest, APieceThatTakesTooLongIsTheOnlyOneOfItsTurn) {
  add('a', 1, 100 * Rounds::kTurn);
  add('b', 1, 1);
  rounds_.begin();
  EXPECT_EQ(turn(), "a");
  EXPECT_EQ(turn(), "b");
}

TEST_F(RoundsTest, ARoundThatIsUnderWayIsNotBegunAgain) {
  add('a', 2, Rounds::kTurn);
  add('b', 1, 1);
  rounds_.begin();
  EXPECT_EQ(turn(), "a");
  rounds_.begin();
  EXPECT_EQ(turn(), "a");
  EXPECT_EQ(turn(), "b");
  EXPECT_FALSE(rounds_.under_way()) << "that round fell out";
}

}  // namespace
}  // namespace mlcca
