// SPDX-License-Identifier: BSD-2-Clause
// period="50ms" and its like: the same values as the elements of the paper, and the same care.
#include "description/short_form.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "description/read.hpp"
#include "description/values.hpp"

namespace mlcca::description {
namespace {

std::string system_with(const std::string& channel, const std::string& network,
                        const std::string& mesh = {}) {
  return fmt::format(
      "<System name=\"s\">\n<EventChannel name=\"c\">\n<SubjectUID>0x1</SubjectUID>\n{}\n"
      "</EventChannel>\n<Network name=\"n\">\n<Kind>{}</Kind>\n{}{}\n</Network>\n</System>\n",
      channel, mesh.empty() ? "other" : "mesh", mesh, network);
}

core::System read_well(const std::string& xml) {
  const auto system = read_memory(xml, "s.xml");
  if (!system) {
    for (const auto& problem : system.error()) ADD_FAILURE() << to_string(problem);
    return {};
  }
  return *system;
}

std::vector<std::string> problems_of(const std::string& xml) {
  std::vector<std::string> out;
  if (const auto system = read_memory(xml, "s.xml"); !system)
    for (const auto& problem : system.error()) out.push_back(to_string(problem));
  return out;
}

const ElementType& requirements() { return *list_named("Attributes"); }

TEST(ShortForm, NamesComeFromTheAttributeTable) {
  EXPECT_EQ(short_name(Attribute::max_payload), "maxPayload");
  for (std::size_t i = 0; i < kAttributes; ++i) {
    EXPECT_EQ(with_short_name(short_name(attribute_at(i))), attribute_at(i));
    EXPECT_EQ(with_short_name(kAttributeTable[i].name), std::nullopt);
  }
  EXPECT_EQ(with_short_name("priority"), std::nullopt);
  EXPECT_EQ(with_short_name("dynamic"), std::nullopt);
}

/// An attribute without one could be stated as an element only.
TEST(ShortForm, TheSchemaHasEveryBuiltInAttribute) {
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const auto name = short_name(attribute_at(i));
    const auto has = [&](const char* list) {
      for (const auto& key : list_named(list)->keys)
        if (key.name == name) return true;
      return false;
    };
    EXPECT_TRUE(has("Attributes")) << name;
    EXPECT_EQ(has("Provision"), attribute_at(i) != Attribute::deadline) << name;
  }
}

TEST(ShortForm, MeansWhatTheElementsMean) {
  const auto brief = read_well(system_with(
      "<Attributes latency=\"5ms\" jitter=\"200us\" deadline=\" 1.5s \" period=\"50ms\" "
      "bandwidth=\"20kB/s\" packetLoss=\"0.5%\" omission=\"2\" maxPayload=\"8B\"/>",
      "<Provision dynamic=\"true\" latency=\"0.0000000015s\" packetLoss=\"0.01\"/>"));
  ASSERT_EQ(brief.channels.size(), 1U);
  const auto& set = brief.channels[0].attributes;
  EXPECT_EQ(set[Attribute::latency], 5'000'000U);
  EXPECT_EQ(set[Attribute::jitter], 200'000U);
  EXPECT_EQ(set[Attribute::deadline], 1'500'000'000U);
  EXPECT_EQ(set[Attribute::period], 50'000'000U);
  EXPECT_EQ(set[Attribute::bandwidth], 20'000U);
  EXPECT_EQ(set[Attribute::packet_loss], 5'000'000U);
  EXPECT_EQ(set[Attribute::omission], 2U);
  EXPECT_EQ(set[Attribute::max_payload], 8U);
  const auto& provision = brief.networks[0].provision;
  EXPECT_EQ(provision[Attribute::latency], 2U);  // 1.5 ns, to the worse side
  EXPECT_TRUE(provision.is_dynamic(Attribute::latency));
  EXPECT_EQ(provision[Attribute::packet_loss], 10'000'000U);
}

TEST(ShortForm, StandsBesideElements) {
  const auto mixed = read_well(
      system_with("<Attributes priority=\"3\" period=\"50ms\">"
                  "<Attribute><Name>Omission</Name><Value>2</Value></Attribute></Attributes>",
                  "<Provision omission=\"1\"/>"));
  const auto& set = mixed.channels.at(0);
  EXPECT_EQ(set.priority, 3);
  EXPECT_EQ(set.attributes[Attribute::period], 50'000'000U);
  EXPECT_EQ(set.attributes[Attribute::omission], 2U);
}

struct Wrong {
  std::string channel;
  std::string network;
  std::string problem;
};

TEST(ShortForm, WhatIsWrongIsSaidWithItsLineAndWhatWouldBeRight) {
  const std::vector<Wrong> all = {
      {"<Attributes\nperiod=\"50\"/>", "",
       "s.xml:5: <Attributes>: attribute period: '50' is not right: it must be a time such as "
       "50ms: "
       "digits, then ns, us, ms or s"},
      {"<Attributes period=\"0ns\"/>", "",
       "s.xml:4: <Attributes>: attribute period: Period must be at least 1 ns; 0ns is less"},
      {"<Attributes packetLoss=\"101%\"/>", "",
       "s.xml:4: <Attributes>: attribute packetLoss: PacketLoss 101% is more than everything: at "
       "most "
       "1"},
      {"<Attributes latency=\"99999999999s\"/>", "",
       "s.xml:4: <Attributes>: attribute latency: Latency 99999999999s is too large: at most "
       "18446744073709551614 ns"},
      {"<Attributes omission=\"2\">\n<Attribute><Name>Omission</Name><Value>2</Value></Attribute>"
       "</Attributes>",
       "", "s.xml:5: <Attribute>: Omission stands here a second time: state it once"},
      {"", "<Provision deadline=\"5ms\"/>",
       "s.xml:8: <Provision>: attribute deadline: Deadline is provided by no network and no "
       "gateway: "
       "it is held against the Latency; state that"},
      {"<Attributes Period=\"5ms\"/>", "",
       "s.xml:4: <Attributes>: attribute Period is not known: Attributes has latency, jitter, "
       "period, "
       "packetLoss, omission, bandwidth, maxPayload, deadline, priority; did you mean period?; a "
       "UserAttribute has a value in an element Attribute"},
  };
  for (const auto& wrong : all)
    EXPECT_EQ(problems_of(system_with(wrong.channel, wrong.network)),
              std::vector<std::string>{wrong.problem});
}

TEST(ShortForm, AHopOfAMeshHasWhatItHasAsElements) {
  const auto fine =
      read_well(system_with("", "", "<Mesh><PerHop latency=\"2ms\" omission=\"1\"/></Mesh>"));
  EXPECT_EQ(fine.networks.at(0).mesh->per_hop[Attribute::latency], 2'000'000U);
  EXPECT_EQ(
      problems_of(system_with("", "", "<Mesh><PerHop bandwidth=\"1kB/s\"/></Mesh>")),
      std::vector<std::string>{
          "s.xml:8: <PerHop>: attribute bandwidth: Bandwidth is not stated per hop: it follows "
          "from the links and packet-bytes of the Mesh"});
}

std::optional<std::string> written(Attribute attribute, std::string_view decimal, int magnitude,
                                   const ElementType& list = requirements()) {
  Dimension dimension = inside(attribute);
  dimension.magnitude = magnitude;
  return write_short(list, attribute, {decimal, dimension});
}

TEST(ShortForm, IsWrittenExactly) {
  EXPECT_EQ(written(Attribute::period, "50", -3), "50ms");
  EXPECT_EQ(written(Attribute::period, "50.10", -3), "50.10ms");  // as it stands
  EXPECT_EQ(written(Attribute::period, "5", -5), "50us");
  EXPECT_EQ(written(Attribute::period, "5", -4), "500us");
  EXPECT_EQ(written(Attribute::period, "5", 3), "5000s");
  EXPECT_EQ(written(Attribute::period, "5", -12), "0.005ns");
  EXPECT_EQ(written(Attribute::bandwidth, "20", 3), "20kB/s");
  EXPECT_EQ(written(Attribute::packet_loss, "0.01", 0), "0.01");
  EXPECT_EQ(written(Attribute::packet_loss, "5", -3), "0.5%");
  EXPECT_EQ(written(Attribute::max_payload, "8", 0), "8");
  EXPECT_EQ(written(Attribute::max_payload, "8.0", 0), "8");
  EXPECT_EQ(written(Attribute::max_payload, "1", 3), "1000");
}

TEST(ShortForm, IsNotWrittenWhereItCannotSayIt) {
  EXPECT_EQ(written(Attribute::max_payload, "8.5", 0), std::nullopt);
  EXPECT_EQ(written(Attribute::omission, "1", -1), std::nullopt);
  EXPECT_EQ(written(Attribute::period, "1", 30), std::nullopt);   // more than 20 digits
  EXPECT_EQ(written(Attribute::period, "1", -30), std::nullopt);  // the same behind the point
  EXPECT_EQ(written(Attribute::deadline, "1", 0, *list_named("Provision")), std::nullopt);
  EXPECT_EQ(written(Attribute::bandwidth, "1", 0, *list_named("PerHop")), std::nullopt);
  EXPECT_EQ(write_short(requirements(), Attribute::period, {"1", {}}), std::nullopt);  // no time
}

TEST(ShortForm, WhatIsWrittenIsReadAsTheSameValue) {
  std::mt19937 random(1);
  std::size_t said = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto attribute = attribute_at(random() % kAttributes);
    std::string decimal = std::to_string(random() >> (random() % 32));
    if (random() % 2 == 0) decimal += "." + std::to_string(random() % 100000);
    Dimension dimension = inside(attribute);
    dimension.magnitude = static_cast<int>(random() % 30) - 20;
    const auto text = write_short(requirements(), attribute, {decimal, dimension});
    if (!text) continue;
    ++said;
    const auto again = read_short(attribute, *text);
    for (const Side side : {Side::requirement, Side::provision}) {
      const auto before = to_value(attribute, decimal, dimension, side);
      const auto after = to_value(attribute, again.decimal, again.dimension, side);
      ASSERT_EQ(before.has_value(), after.has_value()) << decimal << " " << *text;
      if (!before) continue;
      ASSERT_EQ(*before, *after) << decimal << " " << *text;
    }
  }
  EXPECT_GT(said, 10000U);
}

}  // namespace
}  // namespace mlcca::description
