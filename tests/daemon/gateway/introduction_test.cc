// SPDX-License-Identifier: BSD-2-Clause
// Tests of a gateway that is introduced in audit mode: nothing is dropped until an operator
// enforces.
#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>
#include <variant>

#include "tests/daemon/gateway/bench.hpp"

namespace mlcca::test {
namespace {

constexpr std::uint64_t kIntroSecond = 1'000'000'000;
constexpr std::uint64_t kIntroHour = 3600 * kIntroSecond;
constexpr std::size_t kFailing = 1'000;  // calls of the disk

/// A gateway on a machine whose traffic is not yet described completely.
class Introduction : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_NE(::mkdtemp(folder_.data()), nullptr);
    bench_.state_directory = folder_;
    bench_.initial_audit = true;
    ASSERT_FALSE(bench_.start());
  }
  void TearDown() override {
    bench_.end();
    std::filesystem::remove_all(folder_);
  }

  control::Status status() {
    return std::get<control::Status>(bench_.ask(control::StatusRequest{}).reply.body);
  }
  bool is_done(const control::ModeRequest& request) {
    return std::holds_alternative<control::Done>(bench_.ask(request).reply.body);
  }
  void pass(std::uint64_t ns) {
    bench_.clock.monotonic += ns;
    bench_.clock.wall += ns;
    bench_.round();
  }
  /// The daemon is killed, and another one starts.
  void crash() {
    bench_.end();
    ASSERT_FALSE(bench_.start());
  }
  /// After a reboot nothing of the kernel is left, and of the disk everything that was synced.
  void reboot() {
    bench_.end();
    bench_.kernel = FakeKernel{};
    for (const core::Network& n : bench_.system.networks) bench_.kernel.plug(n.name);
    std::mt19937 random;
    bench_.lose_power(random);
    ASSERT_FALSE(bench_.start());
  }
  [[nodiscard]] bool reports(const std::string& words) {
    const auto reasons = status().health.reasons;
    return std::ranges::any_of(
        reasons, [&](const std::string& line) { return line.find(words) != std::string::npos; });
  }

  Bench bench_{small_system()};

 private:
  std::string folder_ = ::testing::TempDir() + "mlcca-introduction-XXXXXX";
};

TEST_F(Introduction, NoGateEnforcesFromTheFirstStartOn) {
  ASSERT_FALSE(bench_.kernel.gates.empty());
  for (const auto& [ifindex, gate] : bench_.kernel.gates)
    EXPECT_EQ(gate.first_mode, gates::Mode::audit) << ifindex;
  EXPECT_EQ(status().mode, "audit");
  EXPECT_TRUE(status().audit_until_enforced);
  EXPECT_TRUE(reports("audit mode until 'mlccactl mode enforce'"));
  EXPECT_TRUE(std::ranges::any_of(bench_.published, [](const control::Event& e) {
    return e.kind == "mode" && e.message.find("AUDIT MODE") == 0;
  }));
}

TEST_F(Introduction, LastsOverRestartsAndRebootsUntilTheGatesEnforceForTheFirstTime) {
  crash();
  EXPECT_EQ(status().mode, "audit");
  reboot();
  EXPECT_EQ(status().mode, "audit");
  EXPECT_TRUE(status().audit_until_enforced);
  ASSERT_TRUE(is_done({"enforce"}));
  bench_.act();
  EXPECT_EQ(status().mode, "enforce");
  EXPECT_FALSE(status().audit_until_enforced);
  crash();
  EXPECT_EQ(status().mode, "enforce");
  reboot();
  EXPECT_EQ(status().mode, "enforce");
  for (const auto& [ifindex, gate] : bench_.kernel.gates)
    EXPECT_EQ(gate.first_mode, gates::Mode::enforce) << ifindex;
}

/// From then on audit mode behaves as on a gateway that was never introduced.
TEST_F(Introduction, AuditModeAfterItEndsWithAReboot) {
  ASSERT_TRUE(is_done({"enforce"}));
  bench_.act();
  ASSERT_TRUE(is_done({"audit"}));
  EXPECT_FALSE(status().audit_until_enforced);
  crash();
  EXPECT_EQ(status().mode, "audit");
  reboot();
  EXPECT_EQ(status().mode, "enforce");
}

TEST_F(Introduction, EndsWhenNothingWouldHaveBeenDroppedForSoLong) {
  ASSERT_TRUE(is_done({"enforce", kIntroHour}));
  reboot();
  EXPECT_EQ(status().mode, "audit") << "it is not over";
  EXPECT_EQ(status().when_clean_ns, kIntroHour);
  pass(kIntroHour);
  pass(kIntroSecond);
  bench_.act();
  EXPECT_EQ(status().mode, "enforce");
  reboot();
  EXPECT_EQ(status().mode, "enforce");
}

/// The gates enforce as requested. That this lasts over a reboot is written to disk later.
TEST_F(Introduction, AnEndThatTheDiskRefusesIsWrittenLater) {
  bench_.disk().trouble(store::test::Trouble::fail, 1, ENOSPC, kFailing);
  ASSERT_TRUE(is_done({"enforce"}));
  bench_.act();
  ASSERT_FALSE(bench_.commits.empty());
  ASSERT_FALSE(bench_.commits.back());
  EXPECT_EQ(status().mode, "enforce");
  bench_.disk().trouble(store::test::Trouble::fail, kFailing, ENOSPC);
  pass(kIntroSecond);
  bench_.act();
  reboot();
  EXPECT_EQ(status().mode, "enforce");
}

TEST_F(Introduction, IsAskedFor) {
  bench_.initial_audit = false;
  reboot();
  for (const auto& [ifindex, gate] : bench_.kernel.gates)
    EXPECT_EQ(gate.first_mode, gates::Mode::enforce) << ifindex;
  ASSERT_TRUE(is_done({"audit"}));
  EXPECT_FALSE(status().audit_until_enforced) << "a reboot ends it";
}

}  // namespace
}  // namespace mlcca::test
