// SPDX-License-Identifier: BSD-2-Clause
// A channel that is not described, through the whole daemon, with frames on the wire.
#include <gtest/gtest.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <sys/socket.h>

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "tests/bpf/ether/packets.hpp"
#include "tests/daemon/start/daemon.hpp"
#include "tests/support/becomes.hpp"

namespace mlcca::test {
namespace {

using Json = nlohmann::json;

constexpr std::uint64_t kSubject = 0x5600000000000001;
const std::string kName = "0x5600000000000001";
constexpr int kRefusedAsInvalid = 2;

constexpr const char* kProvision =
    "<Provision><Attribute><Name>Latency</Name><Dimension><SIUnit><Seconds>1</Seconds></SIUnit>"
    "</Dimension><Value>1</Value></Attribute><Attribute><Name>Period</Name><Dimension><SIUnit>"
    "<Seconds>1</Seconds></SIUnit></Dimension><Value>1</Value></Attribute><Attribute>"
    "<Name>MaxPayload</Name><Dimension><SIUnit><Bytes>1</Bytes></SIUnit></Dimension>"
    "<Value>64</Value></Attribute></Provision>";

/// The one network with a policy.
std::string with_policy(const std::string& allow) {
  std::string text = described(1);
  const std::string end = "</Profile></Network>";
  text.replace(text.find(end), end.size(),
               std::string("</Profile>") + kProvision + "<Unlisted allow=\"" + allow +
                   "\" most=\"1\"/></Network>");
  return text;
}

class UnlistedDaemon : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { make_links(1); }

  int ctl(const std::vector<std::string>& arguments) {
    std::vector<std::string> all = {"mlccactl", "--socket", gateway_.path("control.sock"),
                                    "--json"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const std::string said = gateway_.path("said");
    std::filesystem::remove(said);
    Process asks(all, said);
    const int status = asks.end();
    std::ifstream file(said);
    said_.assign(std::istreambuf_iterator<char>(file), {});
    return status;
  }

  int admit(const std::string& subject) {
    return ctl({"admit", "--subject", subject, "--from", "n0", "--to", "gate", "--offer",
                "Period=10s", "--offer", "MaxPayload=8"});
  }

  /// What the one delivery of the channel has counted; null where there is none.
  Json delivery() {
    if (ctl({"channels"}) != 0) return {};
    const Json all = Json::parse(said_);
    for (const auto& channel : all.at("channels"))
      if (channel.at("subject") == kName) return channel;
    return {};
  }

  std::uint64_t unknown() {
    return ctl({"status"}) != 0 ? 0
                                : Json::parse(said_)
                                      .at("interfaces")
                                      .at(0)
                                      .at("ingress")
                                      .at("unknown")
                                      .get<std::uint64_t>();
  }

  static void send_event() {
    const Fd socket(::socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 0));
    sockaddr_ll to{};
    to.sll_family = AF_PACKET;
    to.sll_ifindex = static_cast<int>(if_nametoindex("far0"));
    const Bytes bytes = frame(Datagram{.subject = kSubject}.whole());
    ASSERT_EQ(::sendto(socket.get(), bytes.data(), bytes.size(), 0,
                       reinterpret_cast<const sockaddr*>(&to), sizeof(to)),  // NOLINT(*-cast)
              static_cast<ssize_t>(bytes.size()));
  }

  void reload(const std::string& description) {
    gateway_.describe(description);
    EXPECT_EQ(ctl({"reload"}), 0) << said_;
  }

  Gateway gateway_{described(1)};
  std::string said_;
};

TEST_F(UnlistedDaemon, IsAdmittedWhereTheDescriptionSaysSoAndNowhereElse) {
  {
    Process daemon(gateway_.command(), gateway_.path("log"));
    ASSERT_TRUE(daemon.ready()) << gateway_.log();
    for (const std::string& closed : {described(1), with_policy("no")}) {
      reload(closed);
      EXPECT_EQ(admit(kName), kRefusedAsInvalid);
      EXPECT_NE(said_.find("n0 admits no channel " + kName + " that is not described"),
                std::string::npos)
          << said_;
    }
    reload(with_policy("0x5600000000000000/8"));
    send_event();
    EXPECT_TRUE(becomes([&] { return unknown() == 1; })) << "allowed is not admitted";
    EXPECT_EQ(admit("0x5700000000000001"), kRefusedAsInvalid) << said_;
    EXPECT_EQ(ctl({"admit", "--subject", kName, "--from", "n0", "--to", "gate"}), kRefusedAsInvalid)
        << "no traffic is stated";
    ASSERT_EQ(admit(kName), 0) << said_;
    EXPECT_EQ(admit("0x5600000000000002"), kRefusedAsInvalid) << "one is allowed: " << said_;
    constexpr int sent = 10;
    for (int i = 0; i < sent; ++i) send_event();
    Json now;
    EXPECT_TRUE(becomes([&] {
      now = delivery();
      return now.is_object() && now.at("passed").get<int>() + now.at("dropped").get<int>() == sent;
    })) << said_;
    // One in 10 s was admitted, and one may come early.
    EXPECT_GE(now.value("passed", 0), 1);
    EXPECT_LE(now.value("passed", sent), 2);
    EXPECT_EQ(now.value("excess", 0), now.value("dropped", sent));
    EXPECT_NE(ctl({"withdraw", "--yes", kName}), 0) << "that is for what is described";
    daemon.signal(SIGKILL);
    EXPECT_EQ(daemon.end(), 128 + SIGKILL);
  }
  Process daemon(gateway_.command(), gateway_.path("log"));
  ASSERT_TRUE(daemon.ready()) << gateway_.log();
  EXPECT_TRUE(delivery().is_object()) << "it outlives the daemon: " << said_;
  reload(with_policy("any"));
  EXPECT_TRUE(delivery().is_object()) << "and a reload";
  reload(described(1));
  EXPECT_FALSE(delivery().is_object()) << "but not the policy";
  const std::uint64_t before = unknown();
  send_event();
  EXPECT_TRUE(becomes([&] { return unknown() == before + 1; }));
  EXPECT_EQ(ctl({"status"}), 0);
  EXPECT_NE(said_.find("is left out: n0 admits no channel " + kName), std::string::npos) << said_;
}

}  // namespace
}  // namespace mlcca::test
