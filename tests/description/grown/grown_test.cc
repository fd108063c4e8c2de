// SPDX-License-Identifier: BSD-2-Clause
// An element that is added to the schema alone (grow.xsl) is known to the recogniser, with its
// place, its attributes and its values, and a default that is another one: no C++ names them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "description/problems.hpp"
#include "description/read.hpp"
#include "description/xml.hpp"

namespace mlcca::description {
namespace {

std::string gateway(std::string_view parts) {
  return fmt::format(R"(<System name="s"><Gateway name="g">{}</Gateway></System>)", parts);
}

constexpr std::string_view kPort = R"(<Port network="n"><Interface name="can0"/></Port>)";

std::string located(std::string_view location) {
  return gateway(fmt::format("{}{}", kPort, location));
}

/// The texts of what is wrong.
std::vector<std::string> problems_of(const std::string& xml) {
  Problems problems("grown.xml");
  parse_text(xml, "", problems, {});
  std::vector<std::string> out;
  for (const auto& problem : problems.take())
    out.push_back(fmt::format("{}: {}", problem.element, problem.text));
  return out;
}

using Texts = std::vector<std::string>;

TEST(GrownSchema, IsFollowedWhereTheElementIsRight) {
  const std::string location =
      R"(<Location room="B-12" floor="-2"><Access> locked </Access></Location>)";
  EXPECT_EQ(problems_of(located("")), Texts{});
  EXPECT_EQ(problems_of(located(location)), Texts{});
  EXPECT_EQ(problems_of(located(location + location)), Texts{});
  EXPECT_EQ(problems_of(located(R"(<Location room="hall"><Access>open</Access></Location>)")),
            Texts{});
}

TEST(GrownSchema, IsFollowedInNumberAndOrder) {
  const std::string location = R"(<Location room="A-1"><Access>open</Access></Location>)";
  EXPECT_EQ(problems_of(located(location + location + location)),
            Texts{"Location: is one too many or out of place: Gateway has Provision, Port, "
                  "Location, in this order"});
  EXPECT_EQ(problems_of(gateway(location + std::string(kPort))),
            Texts{"Location: comes too early: one of Provision, Port belongs before it: "
                  "Gateway has Provision, Port, Location, in this order"});
  EXPECT_EQ(problems_of(located(R"(<Location room="A-1"/>)")),
            Texts{"Location: is not complete: it needs Access"});
}

TEST(GrownSchema, IsFollowedInAttributes) {
  EXPECT_EQ(problems_of(located(R"(<Location><Access>open</Access></Location>)")),
            Texts{"Location: attribute room is missing"});
  EXPECT_EQ(
      problems_of(located(R"(<Location room="A-1" flor="1"><Access>open</Access></Location>)")),
      Texts{"Location: attribute flor is not known: Location has room, floor; did you mean "
            "floor?"});
}

TEST(GrownSchema, IsFollowedInValues) {
  const auto with = [](std::string_view room, std::string_view floor, std::string_view access) {
    return problems_of(located(fmt::format(
        R"(<Location room="{}" floor="{}"><Access>{}</Access></Location>)", room, floor, access)));
  };
  EXPECT_EQ(with("B-12-3", "40", "open"), Texts{});
  for (const auto* room : {"E-1", "B", "B-", "B-123", "B-1-2-3", "hal", "halls"})
    EXPECT_EQ(with(room, "0", "open"),
              Texts{fmt::format("Location: attribute room: '{}' is not right: it must be a wing "
                                "and a number, such as B-12, or hall",
                                room)});
  EXPECT_EQ(with("hall", "41", "open"),
            Texts{"Location: attribute floor: 41 is too large: at most 40"});
  EXPECT_EQ(with("hall", "-3", "open"),
            Texts{"Location: attribute floor: -3 is too small: at least -2"});
  EXPECT_EQ(with("hall", "top", "open"),
            Texts{"Location: attribute floor: 'top' is not right: it must be a whole number of "
                  "floors from -2 to 40"});
  EXPECT_EQ(with("hall", "0", "loked"),
            Texts{"Access: 'loked' is not one of open, locked; did you mean locked?"});
}

TEST(GrownSchema, IsFollowedInDefaults) {
  const auto read = [](std::string_view attributes) {
    return read_memory(
        fmt::format(R"(<System name="s"><Network name="m"><Kind>mesh</Kind><Mesh {}/></Network>)"
                    "</System>",
                    attributes),
        "grown.xml", "", Users::any);
  };
  const auto absent = read(R"(interference="k-hop")");
  ASSERT_TRUE(absent) << to_string(absent.error().front());
  EXPECT_EQ(absent->networks[0].mesh->hops, 5U);
  EXPECT_EQ(read(R"(interference="k-hop" hops="2")")->networks[0].mesh->hops, 2U);
}

}  // namespace
}  // namespace mlcca::description
