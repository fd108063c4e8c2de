// SPDX-License-Identifier: BSD-2-Clause
// The HTML report: complete, of one piece, and harmless whatever the description says.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/tools/design/check/program.hpp"
#include "tools/design/check/drawing.hpp"
#include "tools/design/check/graphviz.hpp"
#include "tools/design/check/tables.hpp"
#include "tools/escape.hpp"

namespace mlcca {
namespace {

using std::chrono::milliseconds;

std::size_t count_of(const std::string& text, std::string_view part) {
  std::size_t n = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size()))
    ++n;
  return n;
}

class HtmlTest : public test::CheckTest {
 protected:
  static std::string html(const std::string& file, int status,
                          const std::string& path = "/usr/bin:/bin") {
    test::Surroundings how;
    how.environment = {"PATH=" + path};
    const auto outcome = test::run({"check", "--format", "html", file}, how);
    EXPECT_EQ(outcome.status, status) << outcome.error;
    EXPECT_EQ(outcome.error, "");
    return outcome.out;
  }
};

TEST_F(HtmlTest, ShowsFindingsChannelsAndNetworksWithADrawing) {
  const auto page = html(file("s.xml", test::system_of(test::delivery(2, 3))), 1);
  EXPECT_TRUE(page.starts_with("<!DOCTYPE html>")) << page.substr(0, 100);
  EXPECT_TRUE(page.ends_with("</html>\n"));
  EXPECT_TRUE(page.contains("<h3>Errors (1)</h3>"));
  EXPECT_FALSE(page.contains("<h3>Warnings"));
  EXPECT_TRUE(page.contains("MLCCA021"));
  EXPECT_TRUE(page.contains("s.xml:5</code>"));
  EXPECT_TRUE(
      page.contains("<td>speed</td><td><code>0x0000000000000001</code></td><td>1</td>"
                    "<td>✗ does not fit</td>"));
  EXPECT_TRUE(
      page.contains("<td>air</td><td>mesh</td><td>Omission 3</td>"
                    "<td>no capacity is stated</td>"));
  EXPECT_EQ(count_of(page, "<svg"), 1U);
  EXPECT_TRUE(page.contains("class=\"edge channel unfit\""));
}

TEST_F(HtmlTest, TheLoadOfABusIsTheTimeThatItsFramesTake) {
  const auto page = html(
      file("s.xml",
           test::system_of(
               "<EventChannel name='speed'><SubjectUID>0x1</SubjectUID>"
               "<Attributes period='10ms' maxPayload='8'/></EventChannel>"
               "<Network name='b'><Kind>can</Kind><Profile>raw</Profile><Bus bitrate='500000'/>"
               "<Binding channel='speed'><Identifier form='standard'>0x10</Identifier></Binding>"
               "</Network><Publisher channel='speed' network='b'/>"
               "<Subscriber channel='speed' network='b'/>")),
      0);
  // 135 bits of 2 us in each 10 ms.
  EXPECT_TRUE(page.contains("2.70 % of the time of the bus")) << page;
  EXPECT_FALSE(page.contains("no capacity is stated"));
}

TEST_F(HtmlTest, LoadsNothingAndRunsNothing) {
  const auto page = html(file("s.xml", test::system_of(test::delivery(2, 2))), 0);
  for (const auto* part :
       {"<script", "<link", "<img", "<iframe", "src=", "@import", "url(", "<!ENTITY"})
    EXPECT_FALSE(page.contains(part)) << part;
  EXPECT_EQ(count_of(page, "<!DOCTYPE"), 1U) << "that of the drawing is taken away";
  EXPECT_EQ(count_of(page, "<?xml"), 0U);
  EXPECT_TRUE(page.contains("default-src 'none'"));
}

TEST_F(HtmlTest, WhatADescriptionSaysStaysText) {
  const std::string hostile = "&lt;script>alert(1)&lt;/script>\"']]&gt;&lt;/td>&amp;amp;";
  const auto page = html(
      file("a<b>'\"&.xml",
           test::system_of(
               "<EventChannel name=\"speed\"><SubjectUID>0x1</SubjectUID><Description>" + hostile +
               "</Description></EventChannel>\n"
               "<Network name=\"air\"><Kind>other</Kind></Network>\n"
               "<Network name=\"sea\"><Kind>other</Kind></Network>\n"
               "<Gateway name=\"shore\"><Port network=\"air\"><Interface alias='" +
               std::string("&lt;script>&amp;amp;\\\"]; x -> y") +
               "'/></Port><Port network=\"sea\"><Interface name=\"eth1\"/></Port>"
               "</Gateway>\n<Publisher channel=\"speed\" network=\"air\"/>\n"
               "<Subscriber channel=\"speed\" network=\"air\"/>\n")),
      0);
  EXPECT_FALSE(page.contains("<script"));
  EXPECT_TRUE(
      page.contains("&lt;script&gt;alert(1)&lt;/script&gt;&quot;&#39;]]&gt;&lt;/td&gt;"
                    "&amp;amp;"));
  EXPECT_TRUE(page.contains("a&lt;b&gt;&#39;&quot;&amp;.xml"));
  // As the drawing writes it: one text, no further node.
  EXPECT_EQ(count_of(page, "class=\"node"), 3U + 2U) << "two networks, a gateway, two ends";
  EXPECT_TRUE(page.contains("&lt;script&gt;&amp;amp;\\&quot;]; x &#45;&gt; y")) << page;
}

TEST_F(HtmlTest, EscapesTextForContentAndAttributes) {
  EXPECT_EQ(tools::html_text("<a b='c' d=\"e\">&\x1b\n"),
            "&lt;a b=&#39;c&#39; d=&quot;e&quot;&gt;&amp;??");
}

TEST_F(HtmlTest, IsCompleteWithoutGraphviz) {
  const auto name = file("s.xml", test::system_of(test::delivery(2, 3)));
  const auto page = html(name, 1, folder());
  EXPECT_TRUE(page.contains("There is no drawing: dot: is not installed.")) << page;
  EXPECT_FALSE(page.contains("<svg"));
  EXPECT_TRUE(page.contains("<h3>Errors (1)</h3>"));
  EXPECT_TRUE(page.contains("<h3>Channels (1)</h3>"));
}

TEST_F(HtmlTest, MarksDynamicNetworksByAWordAndADashedLine) {
  auto text = test::system_of(test::delivery(3, 2));
  text.replace(text.find("<Provision>"), 11, "<Provision dynamic=\"true\">");
  const auto page = html(file("s.xml", text), 0);
  EXPECT_TRUE(page.contains("class=\"node network dynamic\""));
  EXPECT_TRUE(page.contains(">dynamic</text>"));
  EXPECT_TRUE(page.contains("stroke-dasharray"));
  EXPECT_TRUE(page.contains("Omission 2 (best case)"));
  EXPECT_TRUE(page.contains("class=\"edge channel run&#45;time\"") ||
              page.contains("class=\"edge channel run-time\""));
}

TEST_F(HtmlTest, SaysThatAFileCannotBeRead) {
  const auto page = html(path("none.xml"), 2);
  EXPECT_TRUE(page.contains("cannot be read"));
  EXPECT_TRUE(page.contains("MLCCA001"));
  EXPECT_TRUE(page.ends_with("</html>\n"));
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

TEST_F(HtmlTest, DrawsEachDeliveryUpToALimitAndBundlesAboveIt) {
  const int limit = static_cast<int>(tools::design::kMaxSingle);
  const auto single = html(file("single.xml", many(limit, 1)), 1);
  EXPECT_EQ(count_of(single, "class=\"edge channel"), tools::design::kMaxSingle);
  const auto bundled = html(file("bundled.xml", many(limit + 1, 1)), 1);
  EXPECT_EQ(count_of(bundled, "class=\"edge channel"), 2U) << "one for each outcome";
  EXPECT_TRUE(bundled.contains(">60 channels</text>"));
  EXPECT_TRUE(bundled.contains(">1 channel</text>"));
}

TEST_F(HtmlTest, StaysBoundedWithManyChannels) {
  const auto page = html(file("s.xml", many(10'000, 5'000)), 1);
  EXPECT_LT(page.size(), std::size_t{4} << 20U);
  EXPECT_TRUE(page.contains("<svg"));
  EXPECT_TRUE(page.contains("<h3>Errors (5000)</h3>"));
  EXPECT_TRUE(page.contains("3000 more are not shown"));
  EXPECT_TRUE(page.contains("<h3>Channels (10000)</h3>"));
  EXPECT_TRUE(page.contains("8000 more are not shown"));
}

TEST(GraphvizTest, GivesTheDrawingAlone) {
  const auto svg = tools::design::draw_svg("digraph { a -> b }");
  ASSERT_TRUE(svg) << svg.error().text;
  EXPECT_TRUE(svg->starts_with("<svg"));
  EXPECT_TRUE(svg->ends_with("</svg>\n"));
}

TEST(GraphvizTest, SaysWhyThereIsNone) {
  const auto error = [](const char* program, const std::string& source) {
    const auto svg = tools::design::draw_svg(source, program, std::chrono::seconds(60));
    return svg ? "drawn" : svg.error().text;
  };
  EXPECT_EQ(error("mlcca-no-such-program", "digraph {}"),
            "mlcca-no-such-program: is not installed");
  EXPECT_EQ(error("dot", "digraph { a -> "), "dot: has failed");
  EXPECT_EQ(error("true", "digraph {}"), "true: has drawn nothing");
}

/// A program that does `body` instead of drawing.
std::string program(const std::string& path, const std::string& body) {
  FILE* file = std::fopen(path.c_str(), "w");
  std::fputs(("#!/bin/sh\n" + body + "\n").c_str(), file);
  std::fclose(file);
  EXPECT_EQ(::chmod(path.c_str(), 0700), 0);
  return path;
}

TEST_F(HtmlTest, DoesNotWaitForAProgramThatHangs) {
  const auto hangs = program(path("hangs"), "exec tail -f /dev/null");
  const auto silent = tools::design::draw_svg("x", hangs.c_str(), milliseconds(50));
  ASSERT_FALSE(silent);
  EXPECT_TRUE(silent.error().text.contains("needs too long")) << silent.error().text;
  const auto closed = program(path("closed"), "exec tail -f /dev/null >/dev/null");
  const auto lingering = tools::design::draw_svg("x", closed.c_str(), milliseconds(50));
  ASSERT_FALSE(lingering);
  EXPECT_TRUE(lingering.error().text.contains("needs too long")) << lingering.error().text;
}

TEST_F(HtmlTest, ALargeGraphAndALargeDrawingCannotHoldEachOther) {
  const auto copies = program(path("copies"), "echo '<svg>'; exec cat");
  const std::string large(std::size_t{8} << 20U, 'x');
  const auto copied = tools::design::draw_svg(large, copies.c_str());
  ASSERT_TRUE(copied) << copied.error().text;
  EXPECT_EQ(copied->size(), large.size() + 6);
  const auto endless = program(path("endless"), "exec cat /dev/zero");
  const auto refused = tools::design::draw_svg("x", endless.c_str());
  ASSERT_FALSE(refused);
  EXPECT_TRUE(refused.error().text.contains("draws more")) << refused.error().text;
}

}  // namespace
}  // namespace mlcca
