// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/quotas.hpp"

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>

namespace mlcca {
namespace {

constexpr uid_t kAnna = 1000;
constexpr uid_t kBert = 1001;
constexpr uid_t kRoot = 0;
constexpr std::uint64_t kSecond = 1'000'000'000;

/// It is a refusal, and says all of this.
void expect_refused(const std::optional<std::string>& refusal,
                    std::initializer_list<const char*> words) {
  ASSERT_NE(refusal, std::nullopt);
  for (const char* word : words) EXPECT_NE(refusal->find(word), std::string::npos) << *refusal;
}

TEST(PairsQuota, EndsAtItsLimitAndNotBefore) {
  EXPECT_EQ(Quotas::refuse_pairs(0, Quotas::kPairs), std::nullopt);
  EXPECT_EQ(Quotas::refuse_pairs(Quotas::kPairs - 512, 512), std::nullopt);
  expect_refused(Quotas::refuse_pairs(Quotas::kPairs - 511, 512),
                 {"have added 1048065 pairs", "would add 512", "may be 1048576", "release"});
}

class AdmissionQuota : public ::testing::Test {
 protected:
  void admit(uid_t by, std::size_t count = 1) {
    for (std::size_t n = 0; n < count; ++n) held_.put({++last_, control::Admit{}}, by);
  }
  [[nodiscard]] auto refusal(uid_t by) const { return Quotas::refuse_admission(by, held_); }

  store::RecordedAdmissions held_;
  std::uint64_t last_ = 0;
};

TEST_F(AdmissionQuota, AUserHasHisAndNotOneMore) {
  admit(kAnna, Quotas::kOfUser - 1);
  EXPECT_EQ(refusal(kAnna), std::nullopt);
  admit(kAnna);
  expect_refused(refusal(kAnna), {"user 1000 holds 4096", "release"});
  EXPECT_EQ(refusal(kBert), std::nullopt) << "no other user has it";
  held_.erase(1);
  EXPECT_EQ(refusal(kAnna), std::nullopt) << "he has released one";
}

TEST_F(AdmissionQuota, TheOthersTogetherLeaveSomeToRoot) {
  for (uid_t user = kAnna; last_ < Quotas::kOfOthers; ++user) admit(user, Quotas::kOfUser);
  expect_refused(refusal(9999), {"12288", "0 of them are of user 9999"});
  EXPECT_EQ(refusal(kRoot), std::nullopt);
}

TEST_F(AdmissionQuota, RootCountsToo) {
  admit(kRoot, Quotas::kOfAll - 1);
  EXPECT_EQ(refusal(kRoot), std::nullopt);
  admit(kAnna);
  expect_refused(refusal(kRoot), {"16384"});
  expect_refused(refusal(kAnna), {"16384"});
}

TEST_F(AdmissionQuota, MoreThanTheQuotaFromBeforeStaysAndNothingIsAdded) {
  admit(kAnna, Quotas::kOfUser + 100);
  expect_refused(refusal(kAnna), {"holds 4196"});
}

class RowsQuota : public ::testing::Test {
 protected:
  Quotas quotas_;
  std::uint64_t now_ = 50 * kSecond;
};

TEST_F(RowsQuota, AUserMakesHisAndThenWaits) {
  quotas_.charge(kAnna, Quotas::kRowsOfUser.at_once - 1, now_);
  EXPECT_EQ(quotas_.refuse_change(kAnna, now_), std::nullopt);
  quotas_.charge(kAnna, 1, now_);
  expect_refused(quotas_.refuse_change(kAnna, now_), {"user 1000", "10000 rows", "in 1 s"});
  EXPECT_EQ(quotas_.refuse_change(kBert, now_), std::nullopt);
  EXPECT_EQ(quotas_.refuse_change(kRoot, now_), std::nullopt);
  now_ += kSecond / Quotas::kRowsOfUser.per_second;
  EXPECT_EQ(quotas_.refuse_change(kAnna, now_), std::nullopt) << "there is one again";
}

TEST_F(RowsQuota, AChangeThatMadeMoreThanWasLeftIsMadeUpFor) {
  quotas_.charge(kAnna, Quotas::kRowsOfUser.at_once + 50, now_);
  now_ += 10 * kSecond;
  EXPECT_NE(quotas_.refuse_change(kAnna, now_), std::nullopt);
  now_ += kSecond;
  EXPECT_EQ(quotas_.refuse_change(kAnna, now_), std::nullopt);
}

TEST_F(RowsQuota, RootHasMoreButNotEverything) {
  quotas_.charge(kRoot, Quotas::kRowsOfUser.at_once, now_);
  EXPECT_EQ(quotas_.refuse_change(kRoot, now_), std::nullopt);
  quotas_.charge(kRoot, Quotas::kRowsOfRoot.at_once, now_);
  expect_refused(quotas_.refuse_change(kRoot, now_), {"100000 at once"});
}

TEST_F(RowsQuota, WhoHasAllOfHisAgainIsForgotten) {
  quotas_.charge(kAnna, 10, now_);
  quotas_.charge(kBert, 0, now_);
  EXPECT_EQ(quotas_.users(), 1U);
  quotas_.charge(kBert, 1, now_ + 10 * kSecond);
  EXPECT_EQ(quotas_.users(), 1U);
}

}  // namespace
}  // namespace mlcca
