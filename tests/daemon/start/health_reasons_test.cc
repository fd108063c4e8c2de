// SPDX-License-Identifier: BSD-2-Clause
// What is wrong, as the whole daemon reports it to a monitoring system.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/daemon/start/daemon.hpp"
#include "tests/support/becomes.hpp"

namespace mlcca::test {
namespace {

/// A mesh that no channel needs.
std::string mesh_of(const std::string& file) {
  return "<Network name=\"mesh\"><Kind>mesh</Kind><Mesh><Node name=\"robot\" "
         "address=\"192.0.2.1\"/>"
         "<Node name=\"laptop\" address=\"192.0.2.2\"/><Source kind=\"file\" endpoint=\"" +
         file + "\"/></Mesh></Network>\n";
}

/// As the source wants it: a reader never sees half of it.
void put(const std::string& path, const std::string& text) {
  std::ofstream(path + ".new") << text;
  std::filesystem::rename(path + ".new", path);
}

/// What mlccactl prints.
std::string ctl(const Gateway& gateway, std::vector<std::string> arguments) {
  const std::string said = gateway.path("said");
  std::filesystem::remove(said);
  arguments.insert(arguments.begin(), {"mlccactl", "--socket", gateway.path("control.sock")});
  Process asks(arguments, said);
  asks.end();
  std::ifstream file(said);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string check(const Gateway& gateway) { return ctl(gateway, {"status", "--check"}); }

class HealthReasons : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { make_links(1); }
};

TEST_F(HealthReasons, WhatKeepsASourceFromKnowingItsLinksIsAReason) {
  Gateway gateway(described(1));
  const std::string links = gateway.path("links");
  gateway.describe(described(1, mesh_of(links)));
  put(links, "robot laptop 24Mbit/s both\n");
  Process daemon(gateway.command(), gateway.path("log"));
  ASSERT_TRUE(daemon.ready()) << gateway.log();
  EXPECT_EQ(check(gateway).find(links), std::string::npos) << check(gateway);

  put(links, "robot nobody 24Mbit/s\n");
  const std::string reason =
      "mesh: file " + links + ": " + links + ":1: no node has the name or address \"nobody\"";
  EXPECT_TRUE(becomes([&] { return check(gateway).find(reason) != std::string::npos; }))
      << check(gateway);
  EXPECT_EQ(check(gateway).find("DEGRADED"), 0U) << check(gateway);

  put(links, "robot laptop 24Mbit/s both\n");
  EXPECT_TRUE(becomes([&] { return check(gateway).find(links) == std::string::npos; }))
      << check(gateway);
}

TEST_F(HealthReasons, AWithdrawnChannelIsNamedUntilItIsReinstated) {
  Gateway gateway(described(1));
  Process daemon(gateway.command(), gateway.path("log"));
  ASSERT_TRUE(daemon.ready()) << gateway.log();
  const std::string reason = "withdrawn by an operator, until it is reinstated: c0";
  EXPECT_EQ(check(gateway).find(reason), std::string::npos) << check(gateway);
  ctl(gateway, {"withdraw", "--yes", "c0"});
  EXPECT_NE(check(gateway).find(reason), std::string::npos) << check(gateway);
  ctl(gateway, {"reinstate", "c0"});
  EXPECT_EQ(check(gateway).find(reason), std::string::npos) << check(gateway);
}

/// Heart-beats of two publishers that the gate cannot distinguish, unless `addresses` are stated.
std::string look_alikes(bool addresses) {
  const auto attribute = [](const std::string& name, const std::string& unit, int value) {
    return "<Attribute><Name>" + name + "</Name>" + unit + "<Value>" + std::to_string(value) +
           "</Value></Attribute>";
  };
  const std::string ms =
      "<Dimension><SIUnit><Seconds>1</Seconds></SIUnit><Magnitude>-3</Magnitude></Dimension>";
  const std::string bytes =
      "<Dimension><SIUnit><Bytes>1</Bytes></SIUnit><Magnitude>0</Magnitude></Dimension>";
  const std::string provision = "<Provision>" + attribute("Omission", "", 0) +
                                attribute("Latency", ms, 1) + attribute("Jitter", ms, 1) +
                                attribute("Period", ms, 1) + attribute("MaxPayload", bytes, 200) +
                                "</Provision>";
  const auto address = [&](int n) {
    return addresses ? " address=\"10.7.0." + std::to_string(n) + "\"" : std::string();
  };
  return "<System name=\"s\"><EventChannel name=\"hb\"><SubjectUID>0x11</SubjectUID><Attributes>" +
         attribute("Period", ms, 50) + attribute("MaxPayload", bytes, 8) +
         attribute("Omission", "", 2) +
         "</Attributes></EventChannel><Network name=\"n0\"><Kind>udp-multicast</Kind><Profile>"
         "famouso</Profile>" +
         provision + "</Network><Gateway name=\"gate\">" +
         "<Port network=\"n0\"><Interface name=\"lan0\"/></Port></Gateway>"
         "<Publisher name=\"p-hb\" channel=\"hb\" network=\"n0\"" +
         address(2) + "/><Publisher name=\"p-hb2\" channel=\"hb\" network=\"n0\"" + address(3) +
         "/><Subscriber name=\"q\" channel=\"hb\" gateway=\"gate\"/></System>\n";
}

TEST_F(HealthReasons, PublishersThatLookAlikeAreReportedAsNotSupervised) {
  Gateway gateway(look_alikes(false));
  Process daemon(gateway.command(), gateway.path("log"));
  ASSERT_TRUE(daemon.ready()) << gateway.log();
  const std::string why = "the gate cannot distinguish p-hb and p-hb2";
  EXPECT_TRUE(becomes([&] { return check(gateway).contains("not supervised: " + why); }))
      << check(gateway);
  EXPECT_EQ(check(gateway).find("DEGRADED"), 0U) << check(gateway);
  const std::string explained = ctl(gateway, {"explain", "hb"});
  EXPECT_TRUE(explained.contains("reaction     not known: " + why)) << explained;
  EXPECT_FALSE(explained.contains("Omission 2 + 1")) << explained;
  EXPECT_TRUE(ctl(gateway, {"channels"}).contains("not supervised: " + why));
  EXPECT_TRUE(ctl(gateway, {"--json", "channels"}).contains("\"not_supervised\":"))
      << ctl(gateway, {"--json", "channels"});
  EXPECT_TRUE(
      gateway.comes_to_log("hb (0x0000000000000011) of p-hb and p-hb2 towards gate: nothing "
                           "has come since the gate lets it in"))
      << gateway.log();

  gateway.describe(look_alikes(true));
  ctl(gateway, {"reload"});
  EXPECT_TRUE(becomes([&] { return !check(gateway).contains("not supervised"); }))
      << check(gateway);
  EXPECT_TRUE(ctl(gateway, {"explain", "hb"}).contains("Omission 2 + 1"));

  const auto newcomer = [&](const std::string& verb, const std::string& name) {
    return ctl(gateway, {verb, "hb", "--from", "n0", "--offer", "Period=50ms", "--offer",
                         "MaxPayload=8", "--offer", "Omission=0", "--publisher", name});
  };
  EXPECT_TRUE(newcomer("query", "a").contains("Omission 0 + 1")) << newcomer("query", "a");
  newcomer("admit", "a");
  EXPECT_FALSE(check(gateway).contains("not supervised")) << check(gateway);
  EXPECT_TRUE(newcomer("query", "b")
                  .contains("reaction     not known: the gate cannot distinguish a and b"))
      << newcomer("query", "b");
  EXPECT_TRUE(newcomer("admit", "b")
                  .contains("reaction     not known: the gate cannot distinguish a and b"));
  EXPECT_TRUE(becomes([&] {
    return check(gateway).contains("the gate cannot distinguish a and b");
  })) << check(gateway);
}

}  // namespace
}  // namespace mlcca::test
