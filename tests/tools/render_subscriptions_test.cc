// SPDX-License-Identifier: BSD-2-Clause
// Who may subscribe over networks, and what is passed on, as a person reads it.
#include <gtest/gtest.h>

#include "tests/control/messages.hpp"
#include "tools/render.hpp"

namespace mlcca::tools {
namespace {

TEST(RenderSubscriptions, SubscriptionsShowWhoMaySubscribeAndWhatIsPassedOn) {
  EXPECT_EQ(render(test::full_subscriptions(), Color::no),
            "NETWORK     INTERFACE  ACCEPTS  MOST  PROBLEM\n"
            "second-can  can1       all        64  the tag of SUBSCRIB is not known yet\n"
            "\n"
            "CHANNEL           NETWORK     REQUIRED        PROBLEM\n"
            "emergency-switch  second-can  Deadline 43 ms  it requires a user-defined attribute\n");
  control::Subscriptions gateways = test::full_subscriptions();
  gateways.onward.clear();
  gateways.networks[0].accepts_all = false;
  gateways.networks[0].gateways_only = true;
  EXPECT_EQ(render(gateways, Color::no),
            "NETWORK     INTERFACE  ACCEPTS   MOST  PROBLEM\n"
            "second-can  can1       gateways    64  the tag of SUBSCRIB is not known yet\n");
  EXPECT_EQ(render(control::Subscriptions{}, Color::no), "no network accepts subscriptions\n");
}

TEST(RenderSubscriptions, PresenceSaysWhatIsAnnounced) {
  EXPECT_EQ(render(test::full_presence(), Color::no),
            "main announces itself every 500 ms on lan, second-can: it forwards\n"
            "nothing is received of back-up\n");
  control::Presence none;
  none.gateway = "main";
  EXPECT_EQ(render(none, Color::no), "main does not announce itself\n");
}

}  // namespace
}  // namespace mlcca::tools
