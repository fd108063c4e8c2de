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

class HealthReasons : public testing::Test {
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

}  // namespace
}  // namespace mlcca::test
