// SPDX-License-Identifier: BSD-2-Clause
// Why nothing was seen, in words, and how far listening is.
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "tools/design/learn_silence.hpp"

namespace mlcca::tools::design {
namespace {

control::Status gating(const std::string& interface, std::string mode) {
  control::Status out;
  out.mode = std::move(mode);
  control::Interface one;
  one.name = interface;
  one.attached = true;
  out.interfaces.push_back(std::move(one));
  return out;
}

TEST(Silence, NamesItsReason) {
  EXPECT_EQ(reason_of_silence("can0", false, 0, gating("can0", "enforce")),
            "can0: it is down, so nothing comes");
  EXPECT_EQ(reason_of_silence("can0", true, 9, gating("can0", "enforce")),
            "can0: a gate enforces there, and drops what is not admitted before it is seen: learn "
            "in audit mode (mlccactl mode audit)");
  for (const auto& status : {gating("can0", "audit"), gating("can1", "enforce")})
    EXPECT_EQ(reason_of_silence("can0", true, 0, status),
              "can0: nothing came while it was listened to");
  EXPECT_EQ(reason_of_silence("can0", true, 0, {}), "can0: nothing came while it was listened to");
}

TEST(Silence, FramesThatNoProgramSawWereDroppedInTheKernel) {
  EXPECT_EQ(reason_of_silence("can0", true, 120, {}),
            "can0: 120 frames came in, and a filter in the kernel dropped them before a program "
            "could see them. mlccad does not answer: without it its gates are closed, also after "
            "it was stopped. Start it in audit mode (mlccad --initial-mode audit), or learn where "
            "there is no gate");
  EXPECT_EQ(reason_of_silence("can0", true, 1, gating("can1", "enforce")),
            "can0: 1 frame came in, and a filter in the kernel dropped it before a program could "
            "see it: mlccactl status says what is in force there");
}

TEST(Silence, NoDaemonSaysNothing) {
  EXPECT_FALSE(status_of_daemon("/nowhere/control.sock").has_value());
}

TEST(ListeningLine, HasFramesAndTheTimeThatIsLeft) {
  EXPECT_EQ(Listening::line(1, 90'500'000'000), "1 frame so far, 90 s left");
  EXPECT_EQ(Listening::line(4711, 0), "4711 frames so far, 0 s left");
}

}  // namespace
}  // namespace mlcca::tools::design
