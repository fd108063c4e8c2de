// SPDX-License-Identifier: BSD-2-Clause
// How the events of a channel come, in words.
#include <gtest/gtest.h>

#include "tests/control/messages.hpp"
#include "tools/render.hpp"

namespace mlcca::tools {
namespace {

TEST(RenderWatch, OfPublishersThatLookAlikeItShowsTheLatestEventOfAny) {
  auto channel = test::granted_channel();
  channel.watch->shared = true;
  channel.watch->missing_now = false;
  const std::string text = explain(control::Channels{{channel}}, Color::no, true);
  EXPECT_TRUE(text.contains(
      "  watched      only whether none of those that the gate cannot distinguish sends; the "
      "latest event 200 ms ago\n"))
      << text;
  EXPECT_FALSE(text.contains("  gaps  ")) << text;
}

}  // namespace
}  // namespace mlcca::tools
