// SPDX-License-Identifier: BSD-2-Clause
// Random edits of an annotated file against a plain model of it: after each, the file says what the
// model says, fits the schema, and has every comment that it had.
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <string>
#include <vector>

#include "tools/design/describe/edit.hpp"
#include "tools/design/describe/validate.hpp"

namespace mlcca::tools::design {
namespace {

constexpr const char* kStart = R"xml(<?xml version="1.0"?>
<!--1--><?pi one?>
<System name="s"><!--2-->
  <Network name="n"><Kind>other</Kind><!-- </EventChannel> --></Network>
  <EventChannel name="other"><SubjectUID>0x99</SubjectUID></EventChannel><!--3-->

  <EventChannel name='c' > <!--4-->
    <SubjectUID>0x1<!--5--></SubjectUID><!--6-->
    <Description><![CDATA[<Attributes>]]> &lt;<!--7--></Description>
    <!--8-->
  </EventChannel>
  <!--9-->
</System>
<?pi two?>
)xml";

std::vector<std::string> comments_of(const std::string& text) {
  std::vector<std::string> out;
  for (const char* open : {"<!--", "<?pi"})
    for (auto at = text.find(open); at != std::string::npos; at = text.find(open, at + 1))
      out.push_back(text.substr(at, text.find('>', at) - at));
  return out;
}

const std::vector<std::string> kValues = {"Period=50ms",     "Period=0.05s",     "Period=7us",
                                          "Omission=0",      "Omission=12",      "Latency=1.25h",
                                          "MaxPayload=8",    "MaxPayload=2KiB",  "PacketLoss=0.5%",
                                          "PacketLoss=3ppb", "Bandwidth=1Mbit/s"};

TEST(MarkupTest, RandomEditsSayWhatAModelSaysAndKeepEveryComment) {
  std::mt19937 random(1);
  const auto pick = [&](std::size_t n) { return static_cast<std::size_t>(random()) % n; };
  const auto comments = comments_of(kStart);
  ASSERT_EQ(comments.size(), 12U);
  for (int round = 0; round < 40; ++round) {
    Markup markup(kStart);
    std::map<int, std::map<std::string, Quantity>> model;  // of each set, by name
    std::string description = "<Attributes> <";
    for (int step = 0; step < 12; ++step) {
      const int priority = static_cast<int>(pick(3)) - 1;
      const auto quantity = parse_built_in(kValues[pick(kValues.size())]).value();
      switch (pick(4)) {
        case 0:
          description = pick(2) == 0 ? "" : "a & <b>";
          ASSERT_TRUE(apply(markup, 1, SetField{SetField::Which::description, description}));
          break;
        case 1: {
          const auto set = model.find(priority);
          const bool there = set != model.end() && set->second.erase(quantity.name) == 1;
          EXPECT_EQ(apply(markup, 1, UnsetAttribute{quantity.name, priority}).has_value(), there);
          break;
        }
        default:
          ASSERT_TRUE(apply(markup, 1, SetAttribute{quantity, priority}));
          // A new one is a copy of that of the highest priority.
          if (!model.empty()) model.try_emplace(priority, model.rbegin()->second);
          model[priority][quantity.name] = quantity;
      }
      const auto channel = read_channel(markup, *channel_nodes(markup).at(1));
      EXPECT_EQ(channel.description, description);
      std::size_t actual = 0;
      for (const auto& set : channel.sets)
        for (const auto& a : set.attributes) {
          ++actual;
          const auto& of_set = model[set.priority];
          ASSERT_TRUE(of_set.contains(a.name)) << a.name << markup.text();
          EXPECT_TRUE(is_same(of_set.at(a.name), a)) << to_words(a) << markup.text();
        }
      std::size_t expected = 0;
      for (const auto& [of, set] : model) expected += set.size();
      EXPECT_EQ(actual, expected) << markup.text();
      EXPECT_EQ(problems_of_text(markup.text()), std::vector<std::string>{}) << markup.text();
    }
    // The description's own comment goes with it; no other may.
    const auto now = comments_of(markup.text());
    std::size_t missing = 0;
    for (const auto& comment : comments)
      if (std::ranges::find(now, comment) == now.end()) {
        EXPECT_EQ(comment, "<!--7--");
        ++missing;
      }
    EXPECT_LE(missing, 1U);
  }
}

}  // namespace
}  // namespace mlcca::tools::design
