// SPDX-License-Identifier: BSD-2-Clause
// A real gate that is changed between the reading and the frames that prove it, as a daemon does.
#include "tools/readback/replica.hpp"

#include <gtest/gtest.h>
#include <net/if.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <vector>

#include "bpf/ether.h"
#include "daemon/gates/ether_gate.hpp"
#include "daemon/gates/readback.hpp"
#include "tests/daemon/gates/attach_fixture.hpp"

namespace mlcca::readback {
namespace {

using gates::SlotSpec;

class ReplicaTest : public gates::AttachTo {
 protected:
  ReplicaTest() : AttachTo(gates::Hook::clsact) {
    EXPECT_EQ(std::system("ip link add lan0 type veth peer name far0"), 0);
    auto made = gates::EtherGate::attach({if_nametoindex("lan0"), "lan0", 0, hook_}, control_);
    EXPECT_TRUE(made) << made.error().text;
    gate_ = std::make_unique<gates::EtherGate>(std::move(*made));
  }
  ~ReplicaTest() override { EXPECT_EQ(std::system("ip link del lan0"), 0); }

  static SlotSpec subject(std::uint64_t subject, bool admitted) {
    SlotSpec slot;
    slot.pass = admitted;
    slot.formats = ETHER_UNFRAGMENTED;
    slot.subject = subject;
    return slot;
  }
  /// In a process of its own, because no process comes back from the namespaces of the copies.
  [[nodiscard]] int problems_of(const gates::Reading& reading) const {
    const pid_t child = ::fork();
    if (child == 0) {
      const auto trials = try_gates(reading, root_);
      int problems = trials ? 0 : 100;
      if (!trials) std::fprintf(stderr, "%s\n", trials.error().text.c_str());
      for (const Trial& trial : trials.value_or(std::vector<Trial>{})) {
        problems += static_cast<int>(trial.problems.size());
        if (trial.passed == 0) problems += 50;
        for (const auto& problem : trial.problems) std::fprintf(stderr, "%s\n", problem.c_str());
      }
      ::_exit(problems);
    }
    int status = 0;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status));
    return WEXITSTATUS(status);
  }

  std::unique_ptr<gates::EtherGate> gate_;
};

TEST_F(ReplicaTest, FramesAreJudgedByTheTableOfTheReadingAndNotByALaterOne) {
  gates::SlotChanges first;
  first.add = {subject(1, true), subject(2, false)};
  ASSERT_TRUE(gate_->apply(first));
  const auto reading = gates::read_back(root_);
  ASSERT_TRUE(reading) << reading.error().text;
  EXPECT_EQ(problems_of(*reading), 0);

  gates::SlotChanges second;
  second.add = {subject(3, true)};
  second.remove = {subject(1, true)};
  ASSERT_TRUE(gate_->apply(second));
  EXPECT_EQ(problems_of(*reading), 0);
}

}  // namespace
}  // namespace mlcca::readback
