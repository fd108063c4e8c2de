// SPDX-License-Identifier: BSD-2-Clause
// The audit report over reloads of the description.
#include <gtest/gtest.h>

#include <variant>
#include <vector>

#include "tests/daemon/gateway/bench.hpp"

namespace mlcca::test {
namespace {

class AuditOverReloads : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_FALSE(bench_.start()); }

  std::vector<control::Finding> findings() {
    return std::get<control::Audit>(bench_.ask(control::AuditRequest{}).reply.body).findings;
  }
  std::uint64_t frames() {
    std::uint64_t sum = 0;
    for (const control::Finding& f : findings()) sum += f.dropped;
    return sum;
  }
  /// The gate of can0 has dropped so many unknown frames, all of one kind.
  void see(std::uint64_t count) {
    bench_.gates().seen["can0"] = {
        {.can_id = 0x123, .len = 8, .format = GATE_CLASSIC, .count = count, .sequence = count}};
    bench_.gates().unknown["can0"].dropped = count;
  }
  void pass() {
    bench_.clock.monotonic += 1'000'000'000;
    bench_.clock.wall += 1'000'000'000;
    bench_.round();
  }
  void begin_reload() { static_cast<void>(bench_.ask(control::ReloadRequest{})); }
  void end_reload() {
    bench_.reading().finish();
    bench_.round();
  }

  Bench bench_{small_system()};
};

/// The gates count on while a description is put in force.
TEST_F(AuditOverReloads, LosesNoFrames) {
  see(20);
  pass();
  begin_reload();
  see(35);
  bench_.gates().before_frames = [&] { see(40); };
  end_reload();
  bench_.gates().before_frames = nullptr;
  pass();
  EXPECT_EQ(frames(), 40U);
}

TEST_F(AuditOverReloads, SaysWhichPeriodNetworkAndGatewayProvide) {
  bench_.system.networks[0].provision.set(Attribute::period, 50 * kMs);
  begin_reload();
  end_reload();
  see(20);
  pass();
  ASSERT_EQ(findings().size(), 1U);
  EXPECT_EQ(findings()[0].provided_period_ns, std::uint64_t{50 * kMs});
}

}  // namespace
}  // namespace mlcca::test
