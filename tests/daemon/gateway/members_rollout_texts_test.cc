// SPDX-License-Identifier: BSD-2-Clause
// Texts of descriptions on the disk: it may be slow, damaged or full.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>

#include "core/cluster/keys.hpp"
#include "daemon/cluster/record_codec.hpp"
#include "tests/daemon/gateway/members_rollout.hpp"

namespace mlcca::test {
namespace {

class RolledOutTexts : public MembersRollout {
 protected:
  /// Both are in the second one, and the first gateway has been started with the first one.
  void until_in_force() {
    start_both();
    ASSERT_EQ(roll_out(0, "2"), "checking");
    pass(6 * kSecondNs);
    for (std::size_t g = 0; g < 2; ++g) ASSERT_TRUE(has(g, 2)) << g;
  }
  [[nodiscard]] bool reports(std::size_t g, const std::string& words) {
    return std::ranges::any_of(at(g).published, [&](const control::Event& event) {
      return event.message.find(words) != std::string::npos;
    });
  }
  static std::string blob(std::uint8_t digest) {
    return "/mlcca/pair/d/blob/" + core::cluster::hex_of(Sha256::Digest{digest}) + "/0";
  }
  /// What the gateway has said of what is proposed; the other one sees and does nothing meanwhile.
  bool agrees(std::size_t g) {
    const auto& entries = store.entries;
    const cluster::RecordCodec codec(two_gateways(), Sha256::Digest{1});
    const auto vote = entries.find("/mlcca/pair/d/vote/g" + std::to_string(g));
    if (vote == entries.end() || !entries.contains("/mlcca/pair/d/next")) return false;
    const auto said = codec.rollout_vote(vote->second.value);
    return said && said->ok && said->next == entries.at("/mlcca/pair/d/next").mod;
  }
};

TEST_F(RolledOutTexts, AreNeverWaitedForByTheLoop) {
  for (std::size_t g = 0; g < 2; ++g) at(g).threads = true;
  until_in_force();
  EXPECT_EQ(rolled(1, {.back = true}), "checking");
  pass(5 * kSecondNs);
  ASSERT_TRUE(has(0, 1));
  ASSERT_EQ(roll_out(0, "2"), "checking");
  pass(6 * kSecondNs);
  start_again(1);
  pass(4 * kSecondNs);
  at(1).digest = 7;
  at(1).daemon().reload();
  pass(4 * kSecondNs);
  ASSERT_TRUE(has(1, 7));
  EXPECT_EQ(rolled(1, {.accept = true}).find("description"), 0U);
  pass(5 * kSecondNs);
  ASSERT_TRUE(has(1, 2));
  for (std::size_t g = 0; g < 2; ++g) EXPECT_EQ(at(g).texts.in_loop, 0U) << g;
}

TEST_F(RolledOutTexts, ComeFromTheStoreAtAStartWhereTheyAreDamaged) {
  until_in_force();
  at(1).end();
  at(1).texts.damaged = {Sha256::Digest{2}};
  start(1);
  EXPECT_TRUE(has(1, 1)) << "the file";
  pass(8 * kSecondNs);
  EXPECT_TRUE(has(1, 2));
  EXPECT_TRUE(at(1).texts.has(2)) << "kept again";
  EXPECT_TRUE(reports(1, "it is damaged"));
  EXPECT_EQ(asked(1, wanted("c3", "own1", "shared")), "granted");
}

class UncheckedFile : public RolledOutTexts {
 protected:
  /// The second gateway starts with a file, and does not have the description in force any more.
  void start_with(std::uint8_t file, const core::System& system) {
    until_in_force();
    at(1).end();
    at(1).digest = file;
    at(1).system = system;
    at(1).texts.damaged = {Sha256::Digest{2}};
    link(1).up = false;
    start(1);
    ASSERT_TRUE(has(1, file));
    pass(kSecondNs);
  }
  std::string asked_of_its_own() {
    auto request = wanted("c4", "own1", "own1");
    request.key += std::to_string(++asked_);
    return asked(1, request);
  }
  /// By its own file the shared bus is that of the second gateway alone.
  static core::System alone() {
    core::System system = two_gateways();
    std::erase_if(system.gateways[0].ports,
                  [](const core::Port& port) { return port.network == kSharedBus; });
    return system;
  }

 private:
  int asked_ = 0;
};

/// It may have others on networks that are this gateway's own by the file.
TEST_F(UncheckedFile, OpensNothingBeforeTheDescriptionInForceIsKnown) {
  start_with(1, two_gateways());
  EXPECT_NE(asked_of_its_own(), "granted");
  EXPECT_TRUE(reports(1, "all its networks are closed"));
  link(1).up = true;
  pass(8 * kSecondNs);
  EXPECT_TRUE(has(1, 2));
  EXPECT_EQ(asked_of_its_own(), "granted");
}

TEST_F(UncheckedFile, OfAnOperatorIsCheckedWhenTheStoreHasTheText) {
  start_with(7, two_gateways());
  EXPECT_NE(asked_of_its_own(), "granted");
  link(1).up = true;
  pass(5 * kSecondNs);
  EXPECT_TRUE(has(1, 7));
  EXPECT_EQ(asked_of_its_own(), "granted");
  EXPECT_NE(asked(1, wanted("c3", "own1", "shared")), "granted") << "another one is in force";
}

TEST_F(UncheckedFile, ThatTakesOthersOffStaysClosed) {
  start_with(7, alone());
  link(1).up = true;
  pass(5 * kSecondNs);
  EXPECT_NE(asked(1, wanted("c3", "own1", "shared")), "granted");
  EXPECT_NE(asked_of_its_own(), "granted");
  EXPECT_TRUE(reports(1, "roll out one without that network first"));
  EXPECT_EQ(rolled(1, {.accept = true}).find("description"), 0U);
  pass(5 * kSecondNs);
  EXPECT_TRUE(has(1, 2));
  EXPECT_EQ(asked_of_its_own(), "granted");
}

TEST_F(UncheckedFile, StaysClosedWhereNobodyHasTheText) {
  start_with(7, two_gateways());
  store.write({}, {blob(2)});
  link(1).up = true;
  pass(20 * kSecondNs);
  EXPECT_NE(asked_of_its_own(), "granted");
  EXPECT_NE(rolled(1, {.accept = true}).find("does not have the text"), std::string::npos);
}

TEST_F(UncheckedFile, IsNotReloaded) {
  start_with(7, two_gateways());
  store.write({}, {blob(2)});
  link(1).up = true;
  pass(kSecondNs);
  at(1).digest = 8;
  at(1).daemon().reload();
  pass(kSecondNs);
  EXPECT_TRUE(has(1, 7)) << "nothing was changed";
}

/// While the gateway has it in force, its text is not needed.
TEST_F(UncheckedFile, IsHeldAgainstWhatIsLoaded) {
  until_in_force();
  at(1).texts.damaged = {Sha256::Digest{2}};
  store.write({}, {blob(2)});
  at(1).digest = 7;
  at(1).daemon().reload();
  pass(kSecondNs);
  EXPECT_TRUE(has(1, 7));
  EXPECT_EQ(asked_of_its_own(), "granted");
}

TEST_F(RolledOutTexts, ComeFromTheStoreWhereTheyWereDamagedAfterTheVote) {
  propose_to_both();
  at(1).reading().finish();
  link(0).answers = false;
  run();
  at(1).end();
  at(1).texts.damaged = {Sha256::Digest{2}};
  start(1);
  link(0).answers = true;
  finish_reading = true;
  pass(8 * kSecondNs);
  for (std::size_t g = 0; g < 2; ++g) EXPECT_TRUE(has(g, 2)) << g;
}

TEST_F(RolledOutTexts, OfTheFormerOneComeFromTheStoreForAWayBack) {
  until_in_force();
  at(1).texts.damaged = {Sha256::Digest{1}};
  EXPECT_EQ(rolled(1, {.back = true}), "checking");
  pass(6 * kSecondNs);
  for (std::size_t g = 0; g < 2; ++g) EXPECT_TRUE(has(g, 1)) << g;
}

TEST_F(RolledOutTexts, ThatNobodyHasAreReportedAndFollowedWhenTheyAreThere) {
  start_both();
  at(1).end();
  pass(25 * kSecondNs);  // until it is fenced
  ASSERT_EQ(roll_out(0, "2", {"g1"}), "checking");
  pass(60 * kSecondNs);
  ASSERT_EQ(state_of(0).state, "in-force") << state_of(0).why;
  const std::string text = store.entries.at(blob(2)).value;
  store.write({}, {blob(2)});
  start(1);
  pass(5 * kSecondNs);
  EXPECT_TRUE(has(1, 1));
  EXPECT_TRUE(reports(1, "neither kept here nor in the store"));
  store.write({{.key = blob(2), .value = text}});
  pass(5 * kSecondNs);
  EXPECT_TRUE(has(1, 2));
}

TEST_F(RolledOutTexts, OfTheFileAreKeptBeforeItIsAgreedTo) {
  start_both();
  at(1).system = grown_system();
  at(1).digest = 2;
  at(1).daemon().reload();
  pass(kSecondNs);
  ASSERT_TRUE(has(1, 2));
  at(1).texts.all.clear();
  at(1).texts.full = true;
  ASSERT_EQ(roll_out(0, "2"), "checking");
  pass(3 * kSecondNs);
  EXPECT_NE(state_of(0).why.find("g1: it cannot be kept"), std::string::npos) << state_of(0).why;
  at(1).texts.full = false;
  link(1).answers = false;
  ASSERT_EQ(roll_out(0, "2"), "checking");
  run();
  link(0).answers = false;
  link(1).answers = true;
  run();
  ASSERT_TRUE(agrees(1));
  EXPECT_TRUE(at(1).texts.has(2));
}

TEST_F(RolledOutTexts, ThatWereCheckedAreStillThereWhenTheyAreAgreedTo) {
  start_both();
  link(0).answers = false;
  ASSERT_EQ(roll_out(0, "2"), "checking");
  run();
  ASSERT_EQ(state_of(0).state, "staging");
  // The other one is quicker, and what it proposes is objected to.
  at(0).handed_on.erase(3);
  ASSERT_EQ(roll_out(1, "3"), "checking");
  run();
  link(0).answers = true;
  pass(3 * kSecondNs);
  ASSERT_EQ(state_of(1).state, "refused");
  link(0).answers = false;
  ASSERT_EQ(roll_out(1, "2"), "checking");
  run();
  link(1).answers = false;
  link(0).answers = true;
  run();
  ASSERT_TRUE(agrees(0));
  EXPECT_TRUE(at(0).texts.has(2));
}

}  // namespace
}  // namespace mlcca::test
