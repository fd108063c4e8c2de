// SPDX-License-Identifier: BSD-2-Clause
// Two real mlccad with gates in the kernel, each with its mlcca-cluster, and a real etcd.
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>

#include <array>
#include <csignal>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tests/cluster/processes.hpp"
#include "tests/cluster/store.hpp"
#include "tests/support/becomes.hpp"
#include "tests/support/require.hpp"

namespace mlcca::test {
namespace {

/// Both have a port on lan; c0 goes there from programs on gw1, and c1 is for who comes later.
constexpr const char* kSystem = R"(<System name="t">
<EventChannel name="c0"><SubjectUID>0x1</SubjectUID></EventChannel>
<EventChannel name="c1"><SubjectUID>0x2</SubjectUID></EventChannel>
<Network name="lan"><Kind>udp-multicast</Kind><Profile>famouso</Profile><Provision>
<Attribute><Name>Latency</Name><Dimension><SIUnit><Seconds>1</Seconds></SIUnit></Dimension>
<Value>1</Value></Attribute>
<Attribute><Name>Period</Name><Dimension><SIUnit><Seconds>1</Seconds></SIUnit></Dimension>
<Value>1</Value></Attribute>
<Attribute><Name>MaxPayload</Name><Dimension><SIUnit><Bytes>1</Bytes></SIUnit></Dimension>
<Value>64</Value></Attribute>
</Provision></Network>
<Gateway name="gw1"><Port network="lan"><Interface name="lan0"/></Port></Gateway>
<Gateway name="gw2"><Port network="lan"><Interface name="lan0"/></Port></Gateway>
<Publisher channel="c0" gateway="gw1" user="root"/><Subscriber channel="c0" network="lan"/>
</System>
)";

/// A network namespace of the test's own, in which the store runs, and one of each gateway.
void enter_namespaces(const WorkFolder& folder) {
  static bool entered = false;
  if (!entered) {
    require(::unshare(CLONE_NEWNET | CLONE_NEWNS) == 0, "namespaces");
    require(::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0, "private mounts");
    // A gateway closes what it finds and does not know: each has a namespace of its own.
    require(run_script(R"(
ip link set lo up
mkdir -p /run/netns
mount -t tmpfs none /run/netns
)",
                       folder.path()),
            "a folder of namespaces");
    require(make_gateway_links(folder), "links");
    entered = true;
  }
  for (const char* name : {"bpf1", "bpf2"}) {
    std::filesystem::create_directories(folder / name);
    require(::mount("bpf", (folder / name).c_str(), "bpf", 0, nullptr) == 0, "a bpffs");
  }
}

class ClusterDaemons : public testing::Test {
 protected:
  struct Node {
    std::string name;
    Program bridge, daemon;
  };

  ClusterDaemons() {
    enter_namespaces(folder);
    make_certificates(folder);
    write_file(folder / "system.xml", kSystem);
    store.emplace(folder, 1);
    std::string endpoints;
    for (const std::string name : {"gw1", "gw2"}) {
      write_file(folder / (name + ".conf"), "endpoint = " + store->endpoint(0) +
                                                "\nca = " + folder / "ca.pem" +
                                                "\ncertificate = " + folder / (name + ".pem") +
                                                "\nkey = " + folder / (name + ".key") + "\n");
      std::filesystem::create_directories(folder / (name + ".state"));
    }
    nodes[0].name = "gw1";
    nodes[1].name = "gw2";
    for (Node& node : nodes) {
      node.bridge = Program({built("mlcca-cluster"), "--settings", folder / (node.name + ".conf"),
                             "--socket", folder / (node.name + ".cluster")},
                            folder / (node.name + ".bridge.log"));
      start(node);
    }
  }
  ~ClusterDaemons() override {
    for (Node& node : nodes) {
      node.daemon.end();
      node.bridge.end();
    }
    for (const char* name : {"bpf1", "bpf2"}) ::umount((folder / name).c_str());
  }
  ClusterDaemons(const ClusterDaemons&) = delete;
  ClusterDaemons& operator=(const ClusterDaemons&) = delete;

  void start(Node& node) {
    node.daemon = Program({"ip",
                           "netns",
                           "exec",
                           node.name,
                           built("mlccad"),
                           "--description",
                           folder / "system.xml",
                           "--gateway",
                           node.name,
                           "--socket",
                           folder / (node.name + ".sock"),
                           "--bpf-root",
                           folder / ("bpf" + node.name.substr(2)),
                           "--state-directory",
                           folder / (node.name + ".state"),
                           "--cluster-settings",
                           folder / (node.name + ".conf"),
                           "--cluster-socket",
                           folder / (node.name + ".cluster"),
                           "--lease",
                           "4s"},
                          folder / (node.name + ".log"));
  }
  /// What mlccactl says; nothing where it failed.
  std::string ask(const Node& node, std::vector<std::string> arguments, int* status = nullptr) {
    std::vector<std::string> command = {built("mlccactl"), "--socket",
                                        folder / (node.name + ".sock"), "--timeout", "60"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    const std::string said = folder / "said";
    std::filesystem::remove(said);
    const int ended = Program(command, said).wait();
    if (status != nullptr) *status = ended;
    return text_of_file(said);
  }
  bool says(const Node& node, const std::vector<std::string>& arguments, const std::string& words) {
    return becomes([&] { return ask(node, arguments).find(words) != std::string::npos; });
  }
  std::string logs() {
    std::string all;
    for (const Node& node : nodes)
      all += node.name + ":\n" + text_of_file(folder / (node.name + ".log")) +
             text_of_file(folder / (node.name + ".bridge.log"));
    return all;
  }
  /// Keys of a kind that the store has.
  bool has_keys(const std::string& kind) {
    const std::string out = folder / "keys";
    if (!store->control("get --prefix --keys-only /mlcca/t/" + kind + " >" + out)) return true;
    return text_of_file(out).find("/mlcca/") != std::string::npos;
  }
  /// Both have joined.
  bool all_are_there() { return says(nodes[0], {"cluster", "status"}, "2 of 2 are there"); }
  /// On a busy machine the store may answer too late at times.
  bool admits(const Node& node) {
    return becomes([&] { return admit(node) == 0; });
  }
  int admit(const Node& node) {
    int status = -1;
    answer = ask(node,
                 {"admit", "c1", "--from", node.name, "--to", "lan", "--user", "root", "--key", "k",
                  "--offer", "Period=10s", "--offer", "MaxPayload=8"},
                 &status);
    return status;
  }

  WorkFolder folder;
  std::optional<Store> store;
  std::array<Node, 2> nodes;
  std::string answer;
};

TEST_F(ClusterDaemons, OneTruthAboutWhatTheyShare) {
  // Both have the description: it comes into force, and what is described is granted.
  ASSERT_TRUE(says(nodes[0], {"explain", "c0"}, "granted  c0"))
      << ask(nodes[0], {"explain", "c0"}) << logs();
  // What is admitted is reserved first.
  ASSERT_TRUE(admits(nodes[0])) << answer << logs();
  EXPECT_TRUE(has_keys("r/lan/gw1/"));
  // A daemon that was killed takes up where it was.
  nodes[0].daemon.end();
  start(nodes[0]);
  EXPECT_TRUE(says(nodes[0], {"explain", "c1"}, "granted  c1")) << logs();
  EXPECT_TRUE(has_keys("r/lan/gw1/"));
  // Without the store nothing new is granted, and what is leased ends.
  store->kill(0);
  EXPECT_TRUE(says(nodes[0], {"explain", "c1"}, "waits for the store")) << logs();
  EXPECT_TRUE(says(nodes[0], {"explain", "c0"}, "granted  c0"));
  EXPECT_NE(admit(nodes[1]), 0) << answer;
  store->start(0);
  EXPECT_TRUE(says(nodes[0], {"explain", "c1"}, "granted  c1")) << logs();
  // A stop gives it back.
  nodes[0].daemon.signal(SIGTERM);
  EXPECT_EQ(nodes[0].daemon.wait(), 0);
  EXPECT_FALSE(has_keys("r/"));
  EXPECT_FALSE(has_keys("m/gw1"));
}

TEST_F(ClusterDaemons, ASubscriberOfWhatAnotherGatewayHasAdmittedIsOneDecisionOfBoth) {
  const auto subscribes = [&] {
    int status = -1;
    answer = ask(nodes[1], {"admit", "c1", "--to", "gw2", "--key", "s"}, &status);
    return status == 0;
  };
  ASSERT_TRUE(says(nodes[0], {"explain", "c0"}, "granted  c0")) << logs();
  ASSERT_TRUE(all_are_there()) << logs();
  EXPECT_FALSE(subscribes());
  EXPECT_NE(answer.find("no endpoint publishes c1"), std::string::npos) << answer;
  ASSERT_TRUE(admits(nodes[0])) << answer << logs();
  ASSERT_TRUE(becomes(subscribes)) << answer << logs();
  EXPECT_TRUE(says(nodes[1], {"explain", "c1"}, "granted  c1")) << logs();
  EXPECT_TRUE(has_keys("a/gw1/gw2/"));
  EXPECT_TRUE(has_keys("a/gw2/gw1/"));
  EXPECT_FALSE(has_keys("r/lan/gw2/")) << "the traffic of the publisher counts once";
  // Each of them is killed, and both continue.
  for (Node& node : nodes) {
    node.daemon.end();
    start(node);
    EXPECT_TRUE(says(nodes[1], {"explain", "c1"}, "granted  c1")) << node.name << logs();
  }
  ASSERT_TRUE(all_are_there()) << logs();
  // It ends with the publisher.
  int status = -1;
  const std::string released = ask(nodes[0], {"release", "--key", "k"}, &status);
  EXPECT_EQ(status, 0) << released;
  EXPECT_TRUE(becomes([&] { return !has_keys("x/") && !has_keys("r/") && !has_keys("a/"); }))
      << logs();
  EXPECT_TRUE(says(nodes[1], {"history", "--kind", "released"},
                   "gw1: the publisher that it is for is not admitted any more"))
      << logs();
}

/// The same with another one in place of some words.
std::string with(const std::string& words, const std::string& others) {
  std::string out = kSystem;
  return out.replace(out.find(words), words.size(), others);
}

TEST_F(ClusterDaemons, OneDescriptionForAll) {
  write_file(folder / "without.xml", with("<Gateway name=\"gw2\">", "<Gateway name=\"gw4\">"));
  write_file(folder / "grown.xml",
             with("<Publisher channel=\"c0\"",
                  "<xi:include xmlns:xi=\"http://www.w3.org/2001/XInclude\" href=\"more.xml\"/>"
                  "<Publisher channel=\"c2\" gateway=\"gw1\" user=\"root\"/>"
                  "<Subscriber channel=\"c2\" network=\"lan\"/><Publisher channel=\"c0\""));
  write_file(folder / "more.xml",
             "<EventChannel name=\"c2\"><SubjectUID>0x3</SubjectUID></EventChannel>");
  ASSERT_TRUE(says(nodes[0], {"explain", "c0"}, "granted  c0")) << logs();
  ASSERT_TRUE(admits(nodes[0])) << answer << logs();
  ASSERT_TRUE(all_are_there()) << logs();
  int status = -1;
  // One cannot use it: nobody gets it.
  const std::string refused = ask(nodes[0], {"rollout", folder / "without.xml"}, &status);
  EXPECT_EQ(status, 1) << refused << logs();
  EXPECT_NE(refused.find("gw2: "), std::string::npos) << refused;
  EXPECT_TRUE(says(nodes[1], {"explain", "c0"}, "granted  c0"));
  // All can, and what was admitted is there again.
  const std::string done = ask(nodes[0], {"rollout", folder / "grown.xml"}, &status);
  EXPECT_EQ(status, 0) << done << logs();
  for (const Node& node : nodes)
    EXPECT_TRUE(says(node, {"explain", "c2"}, "granted  c2")) << node.name << logs();
  EXPECT_TRUE(says(nodes[0], {"explain", "c1"}, "granted  c1")) << logs();
  EXPECT_TRUE(says(nodes[1], {"history", "--kind", "rollout"}, "is in force"));
  // It outlives a restart, though the file is the former one.
  nodes[1].daemon.end();
  start(nodes[1]);
  EXPECT_TRUE(says(nodes[1], {"explain", "c2"}, "granted  c2")) << logs();
  // And back, from the other one.
  const std::string back = ask(nodes[1], {"rollout", "--back"}, &status);
  EXPECT_EQ(status, 0) << back << logs();
  EXPECT_TRUE(says(nodes[0], {"explain", "c2"}, "no event channel"))
      << ask(nodes[0], {"explain", "c2"});
  EXPECT_TRUE(says(nodes[0], {"explain", "c1"}, "granted  c1")) << logs();
}

TEST_F(ClusterDaemons, AnOperatorSeesItAndTakesAGatewayOut) {
  ASSERT_TRUE(says(nodes[0], {"explain", "c0"}, "granted  c0")) << logs();
  ASSERT_TRUE(admits(nodes[0])) << answer << logs();
  ASSERT_TRUE(all_are_there()) << logs();
  int status = -1;
  std::string said = ask(nodes[0], {"cluster", "status"}, &status);
  EXPECT_EQ(status, 0);
  EXPECT_NE(said.find("gw1 of t"), std::string::npos) << said;
  EXPECT_NE(said.find("phase         in"), std::string::npos) << said;
  EXPECT_NE(said.find("open: lan"), std::string::npos) << said;
  ask(nodes[0], {"cluster", "status", "--check"}, &status);
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(says(nodes[1], {"cluster", "members"}, "gw1      active"));
  EXPECT_TRUE(says(nodes[1], {"cluster", "reservations", "--gateway", "gw1"}, "c1"));
  EXPECT_EQ(ask(nodes[1], {"cluster", "reservations", "gw2"}), "nothing is reserved\n");
  // Another one is drained where it is.
  said = ask(nodes[0], {"cluster", "drain", "gw2", "--yes"}, &status);
  EXPECT_EQ(status, 2);
  EXPECT_NE(said.find("run 'mlccactl cluster drain' on gw2"), std::string::npos) << said;
  ask(nodes[0], {"cluster", "drain", "--yes"}, &status);
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(says(nodes[0], {"cluster", "status"}, "phase         drained")) << logs();
  EXPECT_TRUE(becomes([&] { return !has_keys("r/") && !has_keys("m/gw1"); }));
  EXPECT_TRUE(says(nodes[0], {"explain", "c0"}, "refused  c0"));
  EXPECT_TRUE(says(nodes[0], {"history", "--kind", "gateway"}, "drained: "));
  EXPECT_TRUE(says(nodes[1], {"cluster", "members"}, "gw1      absent"));
  EXPECT_TRUE(says(nodes[0], {"status", "--check"}, "this gateway is drained"));
  // So it stays.
  nodes[0].daemon.signal(SIGTERM);
  EXPECT_EQ(nodes[0].daemon.wait(), 0);
  start(nodes[0]);
  EXPECT_TRUE(says(nodes[0], {"cluster", "status"}, "phase         drained")) << logs();
  ask(nodes[0], {"cluster", "join"}, &status);
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(says(nodes[0], {"explain", "c0"}, "granted  c0")) << logs();
  EXPECT_TRUE(says(nodes[0], {"explain", "c1"}, "granted  c1")) << "it was asked for again";
  // Without the store it says since when, and what closes.
  store->kill(0);
  EXPECT_TRUE(says(nodes[0], {"cluster", "status"}, "store         does not answer"));
  EXPECT_TRUE(says(nodes[0], {"cluster", "status"}, "what is reserved is CLOSED")) << logs();
  ask(nodes[0], {"cluster", "status", "--check"}, &status);
  EXPECT_EQ(status, 1);
}

}  // namespace
}  // namespace mlcca::test
