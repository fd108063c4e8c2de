// SPDX-License-Identifier: BSD-2-Clause
// Gateways with many ports: how many there may be, and who claims whose interface.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <random>
#include <string>
#include <vector>

#include "description/read.hpp"

namespace mlcca::description {
namespace {

std::string networks(int count) {
  std::string out;
  for (int i = 0; i < count; ++i)
    out +=
        fmt::format("<Network name=\"n{}\"><Kind>can</Kind><Profile>raw</Profile></Network>\n", i);
  return out;
}

/// A gateway of `count` lines and one.
std::string gateway(const std::string& name, int count, const std::string& prefix) {
  std::string out = "<Gateway name=\"" + name + "\" host=\"one\">\n";
  for (int i = 0; i < count; ++i)
    out += fmt::format("<Port network=\"n{0}\"><Interface name=\"{1}{0}\"/></Port>\n", i, prefix);
  return out + "</Gateway>\n";
}

std::vector<std::string> problems_of(const std::string& parts) {
  std::vector<std::string> out;
  if (const auto system = read_memory("<System name=\"t\">\n" + parts + "</System>\n", "t.xml");
      !system)
    for (const auto& p : system.error()) out.push_back(to_string(p));
  return out;
}

TEST(Ports, AreSoManyAndNoMore) {
  EXPECT_EQ(problems_of(networks(256) + gateway("g", 256, "can")), std::vector<std::string>{});
  EXPECT_EQ(problems_of(networks(257) + gateway("g", 257, "can")),
            std::vector<std::string>{
                "t.xml:516: <Port>: 257 ports of gateway g are too many: at most 256"});
}

TEST(Ports, OfAllGatewaysOnOneHostAreHeldAgainstEachOther) {
  std::string parts = networks(256);
  for (int g = 0; g < 256; ++g)
    parts += gateway(fmt::format("g{}", g), 256, g == 255 ? "0-" : fmt::format("{}-", g));
  EXPECT_EQ(problems_of(parts).size(), 256U);  // those of the last one
}

/// An interface as a description may state it; empty: that is not stated.
using Stated = std::array<std::string, 5>;
constexpr std::array kNames = {"name", "id-path", "serial", "alias", "port"};

std::string element_of(const Stated& stated) {
  std::string out = "<Interface";
  for (std::size_t p = 0; p < stated.size(); ++p)
    if (!stated.at(p).empty()) out += fmt::format(" {}=\"{}\"", kNames.at(p), stated.at(p));
  return out + "/>";
}

bool states_no_more(const Stated& less, const Stated& more) {
  for (std::size_t p = 0; p < less.size(); ++p)
    if (!less.at(p).empty() && less.at(p) != more.at(p)) return false;
  return true;
}

TEST(Ports, AreOfTheSameInterfaceWhereOneStatesNothingElse) {
  std::mt19937 random(7);
  for (int round = 0; round < 40; ++round) {
    const int count = 40;
    const int first = count + 3;  // line
    std::vector<Stated> all;
    std::vector<std::string> expected;
    std::string ports;
    for (int i = 0; i < count; ++i) {
      Stated stated;
      while (stated == Stated{})
        for (std::string& value : stated)
          value = random() % 2 == 0 ? "" : random() % 2 == 0 ? "1" : "2";
      if (!stated[0].empty()) stated[0] = "w" + stated[0];
      ports += fmt::format("<Port network=\"n{}\">{}</Port>\n", i, element_of(stated));
      for (std::size_t j = 0; j < all.size(); ++j) {
        if (!states_no_more(all[j], stated) && !states_no_more(stated, all[j])) continue;
        expected.push_back(fmt::format(
            "t.xml:{}: <Port>: its Interface is already claimed by the port in line {}: an "
            "interface is on one network",
            first + i, first + static_cast<int>(j)));
        break;
      }
      all.push_back(std::move(stated));
    }
    ASSERT_EQ(problems_of(networks(count) + "<Gateway name=\"g\">\n" + ports + "</Gateway>\n"),
              expected);
  }
}

}  // namespace
}  // namespace mlcca::description
