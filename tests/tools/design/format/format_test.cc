// SPDX-License-Identifier: BSD-2-Clause
// mlccactl format: one form into the other, with all else as it was.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/model/system.hpp"
#include "description/read.hpp"
#include "tests/levels/random_system.hpp"
#include "tests/tools/design/describe/program.hpp"
#include "tools/design/format/rewrite.hpp"

namespace mlcca::tools::design {
namespace {

using test::content_of;
using test::Folder;
using test::run;

std::string in_short(const std::string& text) { return rewritten(text, Form::brief).text; }
std::string in_paper(const std::string& text) { return rewritten(text, Form::paper).text; }

constexpr const char* kPaper = R"xml(<?xml version="1.0"?>
<EventChannel name="c">
  <SubjectUID>0x1</SubjectUID>
  <Attributes>
    <Attribute><Name>Omission</Name><Value>2</Value></Attribute>
    <Attribute>
      <Name>Period</Name>
      <Dimension><SIUnit><Seconds>1</Seconds></SIUnit><Magnitude>-3</Magnitude></Dimension>
      <Value>50</Value>
    </Attribute>
    <Attribute>
      <Name>MaxPayload</Name>
      <Dimension><SIUnit><Bytes>1</Bytes></SIUnit></Dimension>
      <Value>8</Value>
    </Attribute>
  </Attributes>
</EventChannel>
)xml";

constexpr const char* kShort = R"xml(<?xml version="1.0"?>
<EventChannel name="c">
  <SubjectUID>0x1</SubjectUID>
  <Attributes omission="2" period="50ms" maxPayload="8"/>
</EventChannel>
)xml";

TEST(Format, TurnsOneFormIntoTheOther) {
  EXPECT_EQ(in_short(kPaper), kShort);
  EXPECT_EQ(in_paper(kShort), kPaper);
  EXPECT_EQ(in_short(kShort), kShort);
  EXPECT_EQ(in_paper(kPaper), kPaper);
}

std::string with_dos_lines(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '\n' ? std::string("\r\n") : std::string(1, c);
  return out;
}

TEST(Format, KeepsLineEndsAndTheByteOrderMark) {
  const auto marked = [](const std::string& text) { return "\xef\xbb\xbf" + with_dos_lines(text); };
  EXPECT_EQ(in_short(marked(kPaper)), marked(kShort));
  EXPECT_EQ(in_paper(marked(kShort)), marked(kPaper));
}

TEST(Format, AnAttributeWithACommentStaysAnElement) {
  const std::string text = R"xml(<Provision> <!-- measured -->
  <Attribute><Name>Omission</Name><Value>2</Value></Attribute>
  <!-- the worst of a week -->
  <Attribute><Name>PacketLoss</Name><Value>0.01</Value></Attribute>
  <Attribute><Name>Jitter</Name><Dimension><SIUnit><Seconds>1</Seconds></SIUnit></Dimension><Value>1</Value></Attribute> <!-- ? -->
  <Attribute><Name>Latency</Name><Dimension><SIUnit><Seconds>1<!-- s --></Seconds></SIUnit></Dimension><Value>1</Value></Attribute>
</Provision>)xml";
  const auto result = rewritten(text, Form::brief);
  EXPECT_EQ(result.text, R"xml(<Provision omission="2"> <!-- measured -->
  <!-- the worst of a week -->
  <Attribute><Name>PacketLoss</Name><Value>0.01</Value></Attribute>
  <Attribute><Name>Jitter</Name><Dimension><SIUnit><Seconds>1</Seconds></SIUnit></Dimension><Value>1</Value></Attribute> <!-- ? -->
  <Attribute><Name>Latency</Name><Dimension><SIUnit><Seconds>1<!-- s --></Seconds></SIUnit></Dimension><Value>1</Value></Attribute>
</Provision>)xml");
  ASSERT_EQ(result.kept.size(), 3U);
  EXPECT_EQ(result.kept[0].line, 4);
  EXPECT_EQ(result.kept[0].name, "PacketLoss");
  EXPECT_EQ(result.kept[0].why, "a comment stands with it");
}

TEST(Format, WhatTheShortFormCannotSayStaysAnElement) {
  const std::string list =
      "<Provision><Attribute><Name>Own</Name><Value>1</Value></Attribute>"
      "<Attribute dynamic=\"true\"><Name>Omission</Name><Value>1</Value></Attribute>"
      "<Attribute><Name>PacketLoss</Name><Dimension><Magnitude>-30</Magnitude></Dimension>"
      "<Value>1</Value></Attribute></Provision>";
  EXPECT_EQ(in_short(list), list);
  // All of it is dynamic.
  EXPECT_EQ(in_short("<Provision dynamic=\"1\"><Attribute dynamic=\"true\"><Name>Omission</Name>"
                     "<Value>1</Value></Attribute></Provision>"),
            "<Provision dynamic=\"1\" omission=\"1\"/>");
  // The second is reported as such by check; it must not vanish here.
  EXPECT_EQ(in_short("<Attributes omission=\"1\"><Attribute><Name>Omission</Name><Value>2</Value>"
                     "</Attribute></Attributes>"),
            "<Attributes omission=\"1\"><Attribute><Name>Omission</Name><Value>2</Value>"
            "</Attribute></Attributes>");
}

TEST(Format, LongTagsAreBrokenAtAHundredColumns) {
  std::string text =
      "<System name=\"s\">\n  <Network name=\"n\">\n    <Kind>can</Kind>\n    "
      "<Provision latency=\"1000000000ns\" jitter=\"1000000000ns\">\n";
  for (const char* name : {"Period"})
    text += fmt::format(
        "      <Attribute><Name>{}</Name><Dimension><SIUnit><Seconds>1</Seconds>"
        "</SIUnit></Dimension><Value>100000000000000000</Value></Attribute>\n",
        name);
  text +=
      "      <Attribute><Name>Omission</Name><Value>3000000000</Value></Attribute>\n"
      "    </Provision>\n  </Network>\n</System>\n";
  const auto out = in_short(text);
  EXPECT_TRUE(
      out.contains("    <Provision latency=\"1000000000ns\" jitter=\"1000000000ns\" "
                   "period=\"100000000000000000s\"\n               omission=\"3000000000\"/>\n"))
      << out;
  for (std::size_t at = 0, end = 0; end != std::string::npos; at = end + 1) {
    end = out.find('\n', at);
    EXPECT_LE(std::min(end, out.size()) - at, 100U);
  }
}

TEST(Format, PutsElementsBehindTheCommentOnTheLineOfTheTag) {
  EXPECT_EQ(in_paper("<Attributes omission=\"2\" priority=\"1\"> <!-- a -->\n  <!-- b -->\n"
                     "</Attributes>\n"),
            "<Attributes priority=\"1\"> <!-- a -->\n  <Attribute><Name>Omission</Name>"
            "<Value>2</Value></Attribute>\n  <!-- b -->\n</Attributes>\n");
}

void add(std::string& out, const AttributeSet& set, const core::UserValues& user) {
  for (std::size_t i = 0; i < kAttributes; ++i)
    if (set.has(attribute_at(i)))
      out += fmt::format(" {}={}{}", kAttributeTable[i].name, set[attribute_at(i)],
                         set.is_dynamic(attribute_at(i)) ? "?" : "");
  for (const auto& value : user)
    out += fmt::format(" {}={}{}", value.attribute, value.value, value.dynamic ? "?" : "");
}

template <class WithSets>
void add_all(std::string& out, const std::vector<WithSets>& all) {
  for (const auto& one : all) {
    out += "\n" + one.name + ":";
    add(out, one.attributes, one.user);
    for (const auto& lower : one.lower) {
      out += fmt::format(" | {}:", lower.priority);
      add(out, lower.attributes, lower.user);
    }
  }
}

/// All attributes of a description, as they are read, and how many problems it has.
std::string meaning_of(const std::string& path) {
  const auto read = description::examine({path}, {}, description::Users::any);
  std::string out = fmt::format("{} {}", read.readable, read.problems.size());
  if (!read.readable) return out;
  add_all(out, read.system.channels);
  add_all(out, read.system.publishers);
  add_all(out, read.system.subscribers);
  for (const auto& network : read.system.networks) {
    out += "\n" + network.name + ":";
    add(out, network.provision, network.user);
    if (network.mesh) add(out, network.mesh->per_hop, {});
  }
  for (const auto& gateway : read.system.gateways) {
    out += "\n" + gateway.name + ":";
    add(out, gateway.provision, gateway.user);
  }
  return out;
}

/// Of a text that stands in a file beside those that it includes.
void expect_same_meaning_in_both_forms(const std::string& text, const std::string& path) {
  const auto put = [&](const std::string& content) {
    std::ofstream(path, std::ios::binary | std::ios::trunc) << content;
    return meaning_of(path);
  };
  const auto before = put(text);
  const auto brief = in_short(text);
  EXPECT_EQ(put(brief), before) << text << "\n" << brief;
  EXPECT_EQ(in_short(brief), brief) << brief;
  const auto paper = in_paper(brief);
  EXPECT_EQ(put(paper), before) << text << "\n" << paper;
  EXPECT_EQ(in_paper(paper), paper) << paper;
  EXPECT_EQ(put(in_paper(text)), before) << text;
}

TEST(Format, KeepsTheMeaningOfRandomSystems) {
  const Folder folder;
  const auto path = folder.path("s.xml");
  for (std::uint64_t seed = 1; seed <= 300 && !::testing::Test::HasFailure(); ++seed)
    expect_same_meaning_in_both_forms(testing::random_system(seed), path);
}

/// Copies, since files are written beside what they include.
TEST(Format, KeepsTheMeaningOfTheCorpusAndTheExamples) {
  namespace fs = std::filesystem;
  const Folder folder;
  std::size_t compared = 0;
  for (const char* from : {"examples", "tests/corpus/description/good",
                           "tests/corpus/description/bad", "tests/description/twin/cases"}) {
    const fs::path to = folder.path(fs::path(from).filename().string());
    fs::copy(from, to, fs::copy_options::recursive);
    for (const auto& entry : fs::recursive_directory_iterator(to)) {
      const auto path = entry.path().string();
      if (entry.path().extension() != ".xml" || !description::check_part(path).empty()) continue;
      const auto text = content_of(path);
      expect_same_meaning_in_both_forms(text, path);
      std::ofstream(path, std::ios::binary | std::ios::trunc) << text;
      ++compared;
    }
  }
  EXPECT_GT(compared, 100U);
}

TEST(FormatVerb, PrintsWritesOrReplaces) {
  const Folder folder;
  const auto file = folder.write("c.xml", kPaper);
  const auto printed = run({"format", "--short", file});
  EXPECT_EQ(printed.status, 0) << printed.error;
  EXPECT_EQ(printed.out, kShort);
  EXPECT_EQ(content_of(file), kPaper);
  const auto written = run({"format", "--short", file, "-o", folder.path("out.xml")});
  EXPECT_EQ(written.out, folder.path("out.xml") + ": 3 attributes in the short form\n");
  EXPECT_EQ(content_of(folder.path("out.xml")), kShort);
  ASSERT_EQ(::chmod(file.c_str(), 0640), 0);
  EXPECT_EQ(run({"format", "--short", "--in-place", file}).status, 0);
  EXPECT_EQ(content_of(file), kShort);
  struct stat status{};
  ASSERT_EQ(::stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0640U);
  const auto again = run({"format", "--short", "--in-place", file});
  EXPECT_EQ(again.out, file + ": nothing to change\n");
  EXPECT_EQ(run({"format", "--paper", file}).out, kPaper);
}

TEST(FormatVerb, SaysWhatStaysAnElement) {
  const Folder folder;
  const auto file = folder.write(
      "n.xml",
      "<Network name=\"n\">\n<Kind>mesh</Kind>\n<Provision>\n<Attribute><Name>Omission</Name>"
      "<Value>1<!-- x --></Value></Attribute>\n</Provision>\n</Network>\n");
  EXPECT_EQ(run({"format", "--short", "--in-place", file}).out,
            file +
                ": nothing to change\n  line 4: Omission stays an element: a comment stands "
                "with it\n");
  const auto printed = run({"format", "--short", file});
  EXPECT_EQ(printed.out, content_of(file));
  EXPECT_EQ(printed.error, "  line 4: Omission stays an element: a comment stands with it\n");
  const auto json = nlohmann::json::parse(run({"--json", "format", "--short", file}).out);
  EXPECT_EQ(json["changed"], false);
  EXPECT_EQ(json["kept"][0]["line"], 4);
  EXPECT_EQ(json["text"], content_of(file));
}

TEST(FormatVerb, LeavesWhatIsNoDescription) {
  const Folder folder;
  const auto file = folder.write("c.xml", "<EventChannel>\n  <SubjectUID>0x1</SubjectUID>\n");
  const auto ran = run({"format", "--short", "--in-place", file});
  EXPECT_EQ(ran.status, 2);
  EXPECT_TRUE(
      ran.error.contains(file + ": is no valid description; nothing was written\n" + file + ":"))
      << ran.error;
  EXPECT_EQ(content_of(file), "<EventChannel>\n  <SubjectUID>0x1</SubjectUID>\n");
  EXPECT_EQ(run({"format", "--short", folder.path("none.xml")}).status, 2);
  EXPECT_EQ(run({"format", file}).status, 2);
  EXPECT_EQ(run({"format", "--short", "--paper", file}).status, 2);
  EXPECT_EQ(run({"format", "--short", "--in-place", "-o", "x", file}).status, 2);
}

}  // namespace
}  // namespace mlcca::tools::design
