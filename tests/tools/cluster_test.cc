// SPDX-License-Identifier: BSD-2-Clause
// mlccactl cluster: what it prints, what it asks, and when it asks back.
#include <gtest/gtest.h>

#include <string>
#include <variant>
#include <vector>

#include "tests/control/messages.hpp"
#include "tests/control/server.hpp"
#include "tests/tools/run.hpp"
#include "tools/render.hpp"

namespace mlcca {
namespace {

using test::run_mlccactl;
using test::Server;
using tools::Color;

TEST(ClusterVerb, StatusSaysHowItStands) {
  EXPECT_EQ(tools::render(test::full_cluster(), Color::no),
            "gateway       gw1 of robots\n"
            "phase         other-description\n"
            "shared        CLOSED: can-arm, mesh\n"
            "problem       cluster robots: networks of several gateways are closed: the "
            "description in force is another one\n"
            "description   1f0caaaaaaaa of generation 3, in force: this gateway has another one, "
            "2e1dbbbbbbbb\n"
            "lease         10 s, lasts for 8.2 s surely\n"
            "incarnation   41, epoch 000102030405060708090a0b0c0d0e0f\n"
            "store         answers, for 245 s, https://10.0.0.1:2379, in 2 ms, 24 kB, FULL\n"
            "gateways      2 of 3 are there\n"
            "reservations  5 in the store\n"
            "unreadable    1 entry of the store\n");
  auto alone = test::full_cluster();
  alone.shared = "described";
  alone.store_up = false;
  alone.lasts_ns = 0;
  const auto text = tools::render(alone, Color::no);
  EXPECT_TRUE(text.contains("what is reserved is CLOSED, what is described is open: can-arm"));
  EXPECT_TRUE(text.contains("does not answer, for 245 s: it was slow")) << text;
  EXPECT_TRUE(text.contains("10 s, ended: what is reserved is closed")) << text;
}

TEST(ClusterVerb, MembersAndReservationsMarkTheOwnOnes) {
  EXPECT_EQ(
      tools::render(test::full_cluster_members(), Color::no),
      "GATEWAY  STATE    BEAT AGE  LEASE  LASTS  DESCRIPTION               RESERVED  BESIDE  "
      "CARRIES\n"
      "gw1 *    active      1.2 s   10 s  8.2 s  1f0caaaaaaaa (3)                 3  gw2     "
      "video, odometry and 7 more\n"
      "gw2      silent       75 s   10 s         2e1dbbbbbbbb another one         0  gw1\n"
      "gw3      absent                                                            0\n"
      "gw9      removed\n"
      "* this gateway\n"
      "gw9 is not described, and the store has 2 entries of it: nobody can use that any more. "
      "Delete it as root of etcd:\n"
      "  etcdctl del /mlcca/robots/m/gw9 && etcdctl del /mlcca/robots/f/gw9\n");
  auto sends = test::full_cluster_members();
  sends.members.back().removal.clear();
  EXPECT_TRUE(tools::render(sends, Color::no)
                  .ends_with("gw9 is not described, and the store has 2 entries of it: it may "
                             "still send\n"));
  EXPECT_EQ(
      tools::render(test::full_cluster_reservations(), Color::no),
      "NETWORK  GATEWAY  CHANNEL  PUBLISHER    AMOUNT  MESSAGES  PATHS  STATE       THROUGH\n"
      "can-arm  gw1 *    grip     lever       160 B/s         1         granted\n"
      "can-arm  gw2                                                     unreadable\n"
      "mesh     gw1 *    video    camera     400 kB/s                2  pending     gw2, gw3\n"
      "mesh     gw2      map      laser        25 B/s                1  ending\n");
}

TEST(ClusterVerb, AGatewayInNoClusterSaysHowItWouldTakePart) {
  control::Cluster none;
  none.gateway = "gw1";
  EXPECT_TRUE(tools::render(none, Color::no).starts_with("gw1 takes part in no cluster"));
  control::ClusterMembers members;
  members.gateway = "gw1";
  EXPECT_TRUE(tools::render(members, Color::no).contains("/etc/mlcca/cluster.conf"));
  control::ClusterReservations reservations;
  reservations.gateway = "gw1";
  EXPECT_TRUE(tools::render(reservations, Color::no).starts_with("gw1 takes part in no cluster"));
}

/// Answers each part, and remembers nothing.
Server::Answer answered(const control::Request& request) {
  if (const auto* asked = std::get_if<control::ClusterRequest>(&request.body)) {
    if (asked->part == "members") return {{{0, test::full_cluster_members()}}};
    if (asked->part == "reservations") return {{{0, test::full_cluster_reservations()}}};
    return {{{0, test::full_cluster()}}};
  }
  return {{{0, control::Done{"drained"}}}};
}

TEST(ClusterVerb, CheckExitsAsThatOfStatus) {
  Server server(answered);
  const auto outcome = run_mlccactl({"cluster", "status", "--check", "--socket", server.path()});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.out,
            "CLOSED: cluster robots: networks of several gateways are closed: the description in "
            "force is another one; and 1 more\n");
  EXPECT_EQ(run_mlccactl({"cluster", "status", "--check", "--socket", "/nonexistent"}).status, 3);
}

TEST(ClusterVerb, AsksForWhatIsWanted) {
  Server server(answered);
  EXPECT_EQ(run_mlccactl({"cluster", "reservations", "--network", "mesh", "--gateway", "gw2",
                          "--json", "--socket", server.path()})
                .status,
            0);
  const auto asked = std::get<control::ClusterRequest>(server.requests().front().body);
  EXPECT_EQ(asked.part, "reservations");
  EXPECT_EQ(asked.network, "mesh");
  EXPECT_EQ(asked.gateway, "gw2");
  for (const auto& wrong :
       std::vector<std::vector<std::string>>{{"cluster", "members", "--network", "mesh"},
                                             {"cluster", "status", "gw2"},
                                             {"cluster", "join", "--check"},
                                             {"cluster", "members", "--yes"},
                                             {"cluster", "join", "--until-restart"},
                                             {"cluster", "leave"},
                                             {"cluster"}})
    EXPECT_EQ(run_mlccactl(wrong).status, 2) << wrong.back();
}

TEST(ClusterVerb, DrainSaysWhatClosesAndAsksBack) {
  Server server(answered);
  const auto nobody = run_mlccactl({"cluster", "drain", "--socket", server.path()});
  EXPECT_EQ(nobody.status, 2);
  EXPECT_TRUE(nobody.error.contains("state --yes")) << nobody.error;
  const auto done = run_mlccactl({"cluster", "drain", "gw1", "--yes", "--socket", server.path()});
  EXPECT_EQ(done.status, 0);
  EXPECT_EQ(done.out, "drained\n");
  EXPECT_EQ(done.error,
            "gw1: can-arm, mesh close; what it has reserved is given back, until 'mlccactl "
            "cluster join'\n");
  EXPECT_EQ(std::get<control::DrainRequest>(server.requests().back().body).gateway, "gw1");
}

TEST(ClusterVerb, ADrainForAMachineThatIsSwitchedOffSaysSo) {
  Server server(answered);
  const auto done =
      run_mlccactl({"cluster", "drain", "--until-restart", "--yes", "--socket", server.path()});
  EXPECT_EQ(done.status, 0);
  EXPECT_EQ(done.error,
            "gw1: can-arm, mesh close; what it has reserved is given back, until mlccad is started "
            "again\n");
  EXPECT_TRUE(std::get<control::DrainRequest>(server.requests().back().body).until_restart);
}

TEST(ClusterVerb, OfAnotherGatewayTheDaemonAnswers) {
  Server server(answered);
  const auto outcome = run_mlccactl({"cluster", "drain", "gw2", "--socket", server.path()});
  EXPECT_EQ(outcome.error, "") << "nothing here would close";
  EXPECT_EQ(std::get<control::DrainRequest>(server.requests().back().body).gateway, "gw2");
}

}  // namespace
}  // namespace mlcca
