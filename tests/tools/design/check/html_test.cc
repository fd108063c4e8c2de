// SPDX-License-Identifier: BSD-2-Clause
// The HTML report: complete, of one piece, and harmless whatever the description says.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "tests/tools/design/check/program.hpp"
#include "tools/design/check/rows.hpp"
#include "tools/design/check/tables.hpp"
#include "tools/escape.hpp"

namespace mlcca {
namespace {

std::size_t count_of(const std::string& text, std::string_view part) {
  std::size_t n = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size()))
    ++n;
  return n;
}

/// What stands between the two, behind the first `from`.
std::string between(const std::string& text, std::string_view from, std::string_view to) {
  const auto start = text.find(from);
  if (start == std::string::npos) return {};
  const auto begin = start + from.size();
  return text.substr(begin, text.find(to, begin) - begin);
}

/// As a reader has it: without tags.
std::string plain(const std::string& html) {
  std::string out;
  bool in_tag = false;
  for (const char c : html) {
    if (c == '<') in_tag = true;
    if (!in_tag) out += c;
    if (c == '>') {
      in_tag = false;
      out += ' ';
    }
  }
  std::string single;
  for (const char c : out)
    if (c != ' ' && c != '\n')
      single += c;
    else if (!single.empty() && single.back() != ' ')
      single += ' ';
  return single;
}

class HtmlTest : public test::CheckTest {
 protected:
  static std::string html(const std::vector<std::string>& files, int status,
                          const test::Surroundings& how = {}) {
    std::vector<std::string> arguments{"check", "--format", "html"};
    arguments.insert(arguments.end(), files.begin(), files.end());
    const auto outcome = test::run(arguments, how);
    EXPECT_EQ(outcome.status, status) << outcome.error;
    EXPECT_EQ(outcome.error, "");
    return outcome.out;
  }
  static std::string html(const std::string& file, int status) {
    return html(std::vector<std::string>{file}, status);
  }
  /// What a reader of the tables has.
  static std::string text_of(const std::string& page) {
    return plain(between(page, "<body>", "<script"));
  }
  static nlohmann::json maps_of(const std::string& page) {
    return nlohmann::json::parse(between(page, "id=\"maps\">", "</script>"));
  }
};

TEST_F(HtmlTest, ShowsFindingsChannelsAndNetworks) {
  const auto page = html(file("s.xml", test::system_of(test::delivery(2, 3))), 1);
  EXPECT_TRUE(page.starts_with("<!DOCTYPE html>")) << page.substr(0, 100);
  EXPECT_TRUE(page.ends_with("</html>\n"));
  const auto text = text_of(page);
  EXPECT_TRUE(text.contains("Errors (1) Id Where What MLCCA021")) << text;
  EXPECT_FALSE(text.contains("Warnings ("));
  EXPECT_TRUE(text.contains("s.xml:5"));
  EXPECT_TRUE(text.contains("speed 0x0000000000000001 ✕ does not fit")) << text;
  EXPECT_TRUE(text.contains("✕ air Omission 2 required, air provides 3 (1 too many)")) << text;
  EXPECT_TRUE(text.contains("air mesh Omission 3")) << text;
  EXPECT_TRUE(page.contains("scope=\"col\""));
  EXPECT_TRUE(page.contains("scope=\"row\""));
}

TEST_F(HtmlTest, NothingThatIsWrongIsNoneInRed) {
  const auto right = html(file("s.xml", test::system_of(test::delivery(2, 2))), 0);
  EXPECT_TRUE(right.contains("<div class=\"\"><dt>errors</dt><dd>0</dd></div>")) << right;
  EXPECT_TRUE(right.contains("class=\"health good\""));
  const auto wrong = html(file("s.xml", test::system_of(test::delivery(2, 3))), 1);
  EXPECT_TRUE(wrong.contains("<div class=\"bad\"><dt>errors</dt><dd>1</dd></div>"));
  EXPECT_TRUE(wrong.contains("<div class=\"\"><dt>warnings</dt><dd>0</dd></div>"));
  EXPECT_TRUE(wrong.contains("class=\"health bad\""));
}

constexpr const char* kBus =
    "<EventChannel name='speed'><SubjectUID>0x1</SubjectUID>"
    "<Attributes period='10ms' maxPayload='8' deadline='10ms' omission='2'/></EventChannel>"
    "<Network name='b'><Kind>can</Kind><Profile>raw</Profile><Bus bitrate='500000'/>"
    "<Provision omission='0' latency='1ms'/>"
    "<Binding channel='speed'><Identifier form='standard'>0x10</Identifier></Binding>"
    "</Network><Publisher name='wheel' channel='speed' network='b'/>"
    "<Subscriber name='dial' channel='speed' network='b'/>";

TEST_F(HtmlTest, ABusHasItsLoadAndTheResponseOfEachMessage) {
  const auto text = text_of(html(file("s.xml", test::system_of(kBus)), 0));
  // 135 bits of 2 us in each 10 ms.
  EXPECT_TRUE(text.contains("2.70 % of the time of the bus at 500 kbit/s for what is granted"))
      << text;
  EXPECT_FALSE(text.contains("though it is refused"));
  EXPECT_TRUE(text.contains("speed of wheel 0x010 ✓ in time 270 us 1 ms 730 us to spare")) << text;
}

TEST_F(HtmlTest, TheLoadOfABusCountsWhatItsNodesSendThoughItIsRefused) {
  std::string lossy = kBus;
  lossy.replace(lossy.find("omission='0'"), 12, "omission='3'");
  const auto text = text_of(html(file("s.xml", test::system_of(lossy)), 1));
  EXPECT_TRUE(
      text.contains("2.70 % of the time of the bus at 500 kbit/s for what is granted and what "
                    "its own nodes send though it is refused"))
      << text;
  EXPECT_TRUE(text.contains("refused for another reason")) << text;
}

TEST_F(HtmlTest, ADeliveryHasItsSmallestMarginAndItsReaction) {
  const auto text = text_of(html(file("s.xml", test::system_of(kBus)), 0));
  EXPECT_TRUE(text.contains("wheel to dial b Deadline, response times on b: 730 us to spare"))
      << text;
  EXPECT_TRUE(text.contains("= (Omission 2 + 1) x Period 10 ms + Latency")) << text;
  EXPECT_FALSE(text.contains("Attribute set")) << "no channel has several";
}

/// On the second bus less is left of the Deadline than end to end: what is granted may vary so
/// much.
TEST_F(HtmlTest, TheSmallestMarginMayBeThatOfABus) {
  std::string inside;
  std::string bindings;
  const auto add = [&](const std::string& name, int subject, const std::string& attributes) {
    inside += fmt::format(
        "<EventChannel name='{0}'><SubjectUID>{1:#x}</SubjectUID><Attributes {2} maxPayload='8'/>"
        "</EventChannel>",
        name, subject, attributes);
    bindings += fmt::format(
        "<Binding channel='{}'><Identifier form='standard'>{:#x}</Identifier></Binding>", name,
        name == "x" ? 0x100 : subject);
  };
  std::string ends;
  for (int i = 1; i <= 6; ++i) {
    const std::string name = fmt::format("h{}", i);
    add(name, i, "period='50ms'");
    ends += fmt::format(
        "<Publisher channel='{0}' network='a'/><Subscriber channel='{0}' network='a'/>", name);
  }
  add("x", 7, "period='2ms' deadline='8ms'");
  const std::string kind = "<Kind>can</Kind><Profile>raw</Profile><Bus bitrate='500000'/>";
  const auto text = text_of(
      html(file("s.xml",
                test::system_of(inside + "<Network name='a'>" + kind + bindings + "</Network>" +
                                "<Network name='b'>" + kind +
                                "<Binding channel='x'><Identifier form='standard'>0x10</Identifier>"
                                "</Binding></Network>"
                                "<Gateway name='g'><Provision omission='0' latency='0ms'/>"
                                "<Port network='a'><Interface name='can0'/></Port>"
                                "<Port network='b'><Interface name='can1'/></Port></Gateway>" +
                                ends +
                                "<Publisher name='px' channel='x' network='a'/>"
                                "<Subscriber name='sx' channel='x' network='b'/>")),
           0));
  // Seven frames of 270 us, of the one Period that it may take before another bus.
  EXPECT_TRUE(text.contains("x of px 0x100 ✓ in time 1.89 ms 2 ms 110 us to spare")) << text;
  EXPECT_TRUE(text.contains("a › g › b Deadline, response times on a: 110 us to spare")) << text;
  EXPECT_TRUE(text.contains("Deadline, end to end: 49.46 ms to spare")) << text;
}

TEST_F(HtmlTest, AChannelWithoutUseIsNotSaidToFit) {
  const auto text = text_of(html("tests/tools/design/check/cases/unused-channel.xml", 0));
  EXPECT_TRUE(text.contains("– without use nobody publishes it, or nobody subscribes it")) << text;
  EXPECT_TRUE(html("tests/tools/design/check/cases/unused-channel.xml", 0)
                  .contains("<span class=\"unused\"><b>1</b> without use</span>"))
      << "it is a warning";
  EXPECT_FALSE(text.contains("✓ fits nobody")) << text;
}

TEST_F(HtmlTest, ARefusalShowsWhatDoesNotFitAndNotWhatIsOpen) {
  const auto text = text_of(html("examples/volksbot/second-bus.xml", 1));
  EXPECT_TRUE(text.contains("robot-can Omission 2 required, awds provides 5 (3 too many)")) << text;
}

TEST_F(HtmlTest, ALowerAttributeSetIsNamed) {
  const auto text = text_of(html("tests/tools/design/check/cases/lower-set.xml", 0));
  EXPECT_TRUE(text.contains("Attribute set")) << text;
  EXPECT_TRUE(text.contains("(not the preferred one)")) << text;
}

TEST_F(HtmlTest, AMeshHasTheTimeOfItsDomainsAndTheLimit) {
  const auto text = text_of(html("tests/tools/design/check/cases/medium-time-good.xml", 0));
  EXPECT_TRUE(
      text.contains("Medium time of net (1) Domain Taken Limit Left all links 80.00 % "
                    "100.00 % 20.00 %"))
      << text;
}

TEST_F(HtmlTest, ACapacityThatIsStatedHasWhatIsReserved) {
  const auto text = text_of(html(
      file("s.xml", test::system_of("<EventChannel name='speed'><SubjectUID>0x1</SubjectUID>"
                                    "<Attributes period='10ms' maxPayload='8'/></EventChannel>"
                                    "<Network name='n'><Kind>other</Kind><Provision period='10ms' "
                                    "bandwidth='8kB/s' maxPayload='8'/></Network>"
                                    "<Publisher channel='speed' network='n'/>"
                                    "<Subscriber channel='speed' network='n'/>")),
      0));
  EXPECT_TRUE(text.contains("10.00 %: 800 B/s of 8 kB/s")) << text;
}

TEST_F(HtmlTest, LoadsNothingAndRunsItsOwnScriptOnly) {
  const auto page = html(file("s.xml", test::system_of(test::delivery(2, 2))), 0);
  for (const auto* part : {"<link", "<img", "<iframe", "src=", "@import", "url(", "<!ENTITY"})
    EXPECT_FALSE(page.contains(part)) << part;
  EXPECT_EQ(count_of(page, "<!DOCTYPE"), 1U);
  EXPECT_EQ(count_of(page, "<script"), 2U) << "the data, and what draws it";
  EXPECT_TRUE(page.contains("default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-"));
}

TEST_F(HtmlTest, WhatADescriptionSaysStaysText) {
  const std::string hostile =
      "&lt;/script>&lt;script>alert(1)&lt;/script>&lt;img src=x "
      "onerror=alert(1)>\"']]&gt;&amp;amp;";
  auto text = test::system_of(
      "<EventChannel name=\"speed\"><SubjectUID>0x1</SubjectUID><Description>" + hostile +
      "</Description></EventChannel>\n"
      "<Network name=\"air\"><Kind>other</Kind></Network>\n"
      "<Network name=\"sea\"><Kind>other</Kind></Network>\n"
      "<Gateway name=\"shore\"><Port network=\"air\"><Interface alias='" +
      hostile.substr(0, hostile.find('"')) +
      "'/></Port><Port network=\"sea\"><Interface name=\"eth1\"/></Port>"
      "</Gateway>\n<Publisher channel=\"speed\" network=\"air\"/>\n"
      "<Subscriber channel=\"speed\" network=\"air\"/>\n");
  const auto page = html(file("a<b>'\"&.xml", text), 0);
  EXPECT_EQ(count_of(page, "<script"), 2U);
  EXPECT_EQ(count_of(page, "</script"), 2U);
  EXPECT_FALSE(page.contains("<img"));
  EXPECT_TRUE(
      page.contains("&lt;/script&gt;&lt;script&gt;alert(1)&lt;/script&gt;&lt;img src=x "
                    "onerror=alert(1)&gt;&quot;&#39;]]&gt;&amp;amp;"));
  EXPECT_TRUE(page.contains("a&lt;b&gt;&#39;&quot;&amp;.xml"));
}

/// Whatever stands where a name should: it is refused, and shown in the finding and in the drawing.
TEST_F(HtmlTest, HostileNamesStayText) {
  for (const std::string name :
       {"&lt;/script>&lt;script>alert(1)&lt;/script>", "&lt;img src=x onerror=alert(1)>",
        "&quot; onmouseover=&quot;alert(1)", "&apos;;alert(1)//", "&lt;!--&lt;script>",
        "&#x202e;&#x85;&#x7f;&#x9;", "&#x2028;&#x2029;", "\xf0\x9f\x92\xa9"}) {
    auto text = test::system_of(test::delivery(2, 3));
    for (auto at = text.find("\"air\""); at != std::string::npos; at = text.find("\"air\"", at + 1))
      text.replace(at, 5, "\"" + name + "\"");
    const auto outcome = test::run({"check", "--format", "html", file("s.xml", text)});
    EXPECT_NE(outcome.status, -1);
    const auto& page = outcome.out;
    EXPECT_TRUE(page.ends_with("</html>\n")) << name;
    EXPECT_EQ(count_of(page, "<script"), 2U) << name;
    EXPECT_EQ(count_of(page, "</script"), 2U) << name;
    EXPECT_FALSE(page.contains("<img")) << name;
    EXPECT_FALSE(page.contains("onmouseover=\"")) << name;
    EXPECT_FALSE(page.contains("<!--")) << name;
    EXPECT_FALSE(page.contains('\x7f')) << name;
    EXPECT_TRUE(maps_of(page).is_array()) << name;
  }
}

TEST_F(HtmlTest, EscapesTextForContentAttributesAndScripts) {
  EXPECT_EQ(tools::html_text("<a b='c' d=\"e\">&\x1b\n"),
            "&lt;a b=&#39;c&#39; d=&quot;e&quot;&gt;&amp;??");
  EXPECT_EQ(tools::json_in_markup(R"({"a":"</script><!--"})"),
            R"({"a":"\u003c/script>\u003c!--"})");
  EXPECT_EQ(tools::design::path_text("a/<b>"), "a/<wbr>&lt;b&gt;");
}

TEST_F(HtmlTest, TheDrawingHasPlacesWhatJoinsThemAndWays) {
  const auto maps = maps_of(html("examples/rover/system.xml", 0));
  ASSERT_EQ(maps.size(), 1U);
  const auto& map = maps[0];
  ASSERT_EQ(map["places"].size(), 4U);
  EXPECT_EQ(map["places"][0]["label"], "drive-bus");
  EXPECT_EQ(map["places"][0]["bitrate"], 250'000);
  EXPECT_EQ(map["places"][3]["label"], "rover");
  EXPECT_EQ(map["places"][3]["next"], nlohmann::json({0, 1, 2}));
  std::size_t deliveries = 0;
  for (const auto& way : map["ways"]) {
    deliveries += way["many"].get<std::size_t>();
    EXPECT_EQ(way["route"].front(), way["from"]);
    EXPECT_EQ(way["route"].back(), way["to"]);
  }
  EXPECT_EQ(deliveries, 5U);
}

TEST_F(HtmlTest, ARefusalEndsWhereItDoesNotFit) {
  const auto map = maps_of(html("examples/volksbot/system.xml", 1))[0];
  ASSERT_EQ(map["ways"].size(), 1U);
  const auto& way = map["ways"][0];
  EXPECT_EQ(way["outcome"], "unfit");
  ASSERT_EQ(way["route"].size(), 3U);
  EXPECT_EQ(way["stop"], way["route"][1]) << "at the gateway";
  EXPECT_EQ(map["places"][way["stop"].get<std::size_t>()]["ill"], true);
}

TEST_F(HtmlTest, MarksBestCasesByAWord) {
  auto text = test::system_of(test::delivery(3, 2));
  text.replace(text.find("<Provision>"), 11, "<Provision dynamic=\"true\">");
  const auto page = html(file("s.xml", text), 0);
  EXPECT_EQ(maps_of(page)[0]["places"][0]["note"], "best cases only");
  EXPECT_TRUE(text_of(page).contains("Omission 2 (best case)"));
  EXPECT_TRUE(text_of(page).contains("◌ decided at run time"));
}

TEST_F(HtmlTest, SaysThatAFileCannotBeRead) {
  const auto page = html(path("none.xml"), 2);
  EXPECT_TRUE(page.contains("cannot be read"));
  EXPECT_TRUE(page.contains("MLCCA001"));
  EXPECT_TRUE(page.ends_with("</html>\n"));
}

TEST_F(HtmlTest, SeveralSystemsAreOnePage) {
  const auto page = html({"examples/volksbot/system.xml", "examples/rover/system.xml",
                          file("s.xml", test::system_of(test::delivery(2, 3)))},
                         1);
  EXPECT_EQ(count_of(page, "<section class=\"system\""), 3U);
  EXPECT_EQ(count_of(page, "class=\"map\""), maps_of(page).size());
  EXPECT_TRUE(page.contains("<a href=\"#s3-title\">test</a>"));
  std::set<std::string> ids;
  for (auto at = page.find(" id=\""); at != std::string::npos; at = page.find(" id=\"", at + 1))
    EXPECT_TRUE(ids.insert(page.substr(at, page.find('"', at + 5) - at)).second)
        << page.substr(at, 30);
  EXPECT_EQ(count_of(page, "<h1>"), 1U);
}

TEST_F(HtmlTest, PathsAreShort) {
  using tools::design::FileNames;
  const FileNames names({"/home/p/a/s.xml", "/home/p/b/t.xml", "x/y.xml", "/srv/tree/z.xml"},
                        "/srv/tree");
  EXPECT_EQ(names.of("x/y.xml"), "x/y.xml");
  EXPECT_EQ(names.of("/srv/tree/z.xml"), "z.xml");
  EXPECT_EQ(names.of("/home/p/a/s.xml"), "a/s.xml");
  const FileNames alone({"/home/p/a/s.xml"}, "/");
  EXPECT_EQ(alone.of("/home/p/a/s.xml"), "home/p/a/s.xml");
  const FileNames outside({"/home/p/a/s.xml"}, "/srv");
  EXPECT_EQ(outside.of("/home/p/a/s.xml"), "s.xml");
  EXPECT_EQ(outside.of(""), "");
  const auto page = html(file("s.xml", test::system_of(test::delivery(2, 3))), 1);
  EXPECT_FALSE(page.contains(folder())) << "nobody else has that folder";
}

/// `channels` channels between two networks, of which the first `bad` do not fit.
std::string many(int channels, int bad) {
  std::string parts =
      "<Network name=\"west\"><Kind>other</Kind><Provision><Attribute><Name>Omission</Name>"
      "<Value>3</Value></Attribute></Provision></Network>\n"
      "<Network name=\"east\"><Kind>other</Kind><Provision><Attribute><Name>Omission</Name>"
      "<Value>0</Value></Attribute></Provision></Network>\n"
      "<Gateway name=\"g\"><Provision><Attribute><Name>Omission</Name><Value>0</Value></Attribute>"
      "</Provision><Port network=\"west\"><Interface name=\"w\"/></Port>"
      "<Port network=\"east\"><Interface name=\"e\"/></Port></Gateway>\n";
  for (int i = 0; i < channels; ++i)
    parts += fmt::format(
        "<EventChannel name=\"c{0}\"><SubjectUID>0x{1:x}</SubjectUID><Attributes><Attribute>"
        "<Name>Omission</Name><Value>{2}</Value></Attribute></Attributes></EventChannel>\n"
        "<Publisher channel=\"c{0}\" network=\"west\"/>\n"
        "<Subscriber channel=\"c{0}\" network=\"east\"/>\n",
        i, i + 1, i < bad ? 2 : 3);
  return test::system_of(parts);
}

TEST_F(HtmlTest, ChannelsOfOneWayAreOneWay) {
  const auto map = maps_of(html(file("s.xml", many(61, 1)), 1))[0];
  ASSERT_EQ(map["ways"].size(), 2U) << "one for each outcome";
  EXPECT_EQ(map["ways"][0]["many"], 1);
  EXPECT_EQ(map["ways"][1]["many"], 60);
}

TEST_F(HtmlTest, StaysBoundedWithManyChannels) {
  const auto page = html(file("s.xml", many(10'000, 5'000)), 1);
  EXPECT_LT(page.size(), std::size_t{4} << 20U);
  const auto text = text_of(page);
  EXPECT_TRUE(text.contains("Errors (5000)"));
  EXPECT_TRUE(text.contains("3000 more are not shown"));
  EXPECT_TRUE(text.contains("Channels, by delivery (10000)"));
  EXPECT_TRUE(text.contains("8000 more are not shown"));
}

}  // namespace
}  // namespace mlcca
