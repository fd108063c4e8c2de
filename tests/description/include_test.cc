// SPDX-License-Identifier: BSD-2-Clause
// Files that include files: what comes of it is what a plain XInclude processor makes of it, and
// what is wrong is said of the right file and line.
#include "description/include.hpp"

#include <fmt/format.h>
#include <libxml/parser.h>
#include <libxml/tree.h>
#include <libxml/xinclude.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "core/design/findings.hpp"
#include "description/read.hpp"
#include "tests/description/folder.hpp"

namespace mlcca::description {
namespace {

constexpr const char* kSpace = "xmlns:xi=\"http://www.w3.org/2001/XInclude\"";

std::string system_of(const std::string& parts) {
  return fmt::format("<System name=\"test\" {}>\n{}</System>\n", kSpace, parts);
}

std::string include(const std::string& href) { return "<xi:include href=\"" + href + "\"/>\n"; }

std::string channel(const std::string& name, int subject) {
  return fmt::format("<EventChannel name=\"{}\"><SubjectUID>{:#x}</SubjectUID></EventChannel>\n",
                     name, subject);
}

/// Each problem without the folder, joined by '|'.
std::string said(const std::vector<Problem>& problems, const std::string& folder) {
  std::string out;
  for (const auto& p : problems) {
    auto text = to_string(p);
    while (!folder.empty() && text.contains(folder)) text.erase(text.find(folder), folder.size());
    out += (out.empty() ? "" : "|") + text;
  }
  return out;
}

class Include : public WithFolder {
 protected:
  /// What is wrong with s.xml.
  std::string problems() {
    const auto result = read(path("s.xml"));
    return result ? "" : said(result.error(), path(""));
  }
  /// What is wrong with a System that holds this.
  std::string problems_of(const std::string& parts) {
    file("s.xml", system_of(parts));
    return problems();
  }
  core::System system() {
    auto result = read(path("s.xml"));
    EXPECT_TRUE(result) << problems();
    return result ? std::move(*result) : core::System{};
  }
  /// The names of the channels with where they stand.
  std::vector<std::string> channels(const core::System& s) {
    std::vector<std::string> out;
    for (const auto& c : s.channels)
      out.push_back(fmt::format("{} {}:{}", c.name,
                                s.files.at(c.origin.file).substr(path("").size()), c.origin.line));
    return out;
  }
};

using Names = std::vector<std::string>;

TEST_F(Include, ReplacesTheElementByTheRootOfTheFile) {
  file("b.xml", "<?xml version=\"1.0\"?>\n<!-- comment -->\n" + channel("b", 2));
  file("s.xml", system_of(channel("a", 1) + include("b.xml") + channel("c", 3)));
  EXPECT_EQ(channels(system()), (Names{"a s.xml:2", "b b.xml:3", "c s.xml:4"}));
  EXPECT_EQ(system().files, (Names{path("s.xml"), path("b.xml")}));
}

TEST_F(Include, StartsFromTheFolderOfTheIncludingFile) {
  file("parts/arm/hand.xml", channel("hand", 2));
  file("parts/arm/arm.xml", fmt::format("<Component name=\"arm\" network=\"air\" {}>{}</Component>",
                                        kSpace, include("hand.xml") + include("../leg.xml")));
  file("parts/leg.xml", channel("leg", 3));
  file("s.xml", system_of("<Network name=\"air\"><Kind>mesh</Kind></Network>\n" +
                          include("parts/arm/arm.xml") + include(path("parts/leg2.xml"))));
  file("parts/leg2.xml", channel("leg2", 4));
  EXPECT_EQ(channels(system()), (Names{"hand parts/arm/hand.xml:1", "leg parts/arm/../leg.xml:1",
                                       "leg2 parts/leg2.xml:1"}));
}

TEST_F(Include, DecodesTheName) {
  file("a b#c?d%e:ä.xml", channel("b", 2));
  file("s.xml", system_of(include("a%20b%23c%3fd%25e%3A\xc3\xa4.xml")));
  EXPECT_EQ(system().channels.size(), 1U);
}

TEST_F(Include, ReadsAFileAsOftenAsItIsNamed) {
  file("b.xml", channel("b", 2));
  EXPECT_EQ(problems_of(include("b.xml") + include("b.xml")).substr(0, 32),
            "b.xml:1: <EventChannel>: the nam");
  EXPECT_EQ(read(path("s.xml")).error().size(), 2U) << "the name and the subject";
}

TEST_F(Include, GivesWhatAPlainProcessorGives) {
  file("b.xml", channel("b", 2));
  file("c/d.xml", channel("d", 5));
  file("c/c.xml",
       fmt::format("<Component name=\"c\" network=\"air\" {}><Description>x</Description>"
                   "{}{}<Publisher channel=\"d\"/></Component>",
                   kSpace, include("../b.xml"), include("d.xml")));
  file("s.xml", system_of("<Network name=\"air\"><Kind>mesh</Kind></Network>\n" + channel("a", 1) +
                          include("c/c.xml") + channel("z", 9)));
  const std::unique_ptr<xmlDoc, FreeWith<xmlFreeDoc>> document(
      xmlReadFile(path("s.xml").c_str(), nullptr, XML_PARSE_NONET));
  ASSERT_GT(xmlXIncludeProcessFlags(document.get(), XML_PARSE_NOXINCNODE), 0);
  xmlChar* memory = nullptr;
  int size = 0;
  xmlDocDumpMemory(document.get(), &memory, &size);
  const std::string flat(reinterpret_cast<const char*>(memory), static_cast<std::size_t>(size));
  xmlFree(memory);
  ASSERT_TRUE(flat.contains("xml:base")) << "the processor says where parts come from";
  const auto plain = read_memory(flat, "flat.xml");
  ASSERT_TRUE(plain) << said(plain.error(), "");
  const auto ours = system();
  const auto names = [](const core::System& s) {
    Names out;
    for (const auto& c : s.channels) out.push_back(c.name);
    for (const auto& p : s.publishers) out.push_back(p.name);
    return out;
  };
  EXPECT_EQ(names(ours), names(*plain));
  EXPECT_EQ(ours.channels.size(), 4U);
}

TEST_F(Include, SaysWhatIsWrongInAFileOfThatFile) {
  file("b.xml", "<!-- -->\n<EventChannel name=\"b\">\n<SubjectUID>2</SubjectUID></EventChannel>");
  file("c.xml", "<EventChannel name=\"c\">\n<SubjectUID>0x3</SubjectUID></EventChanel>");
  EXPECT_EQ(
      problems_of(include("b.xml") + include("c.xml") + "<Zebra/>\n"),
      "s.xml:4: <Zebra>: is not known here; known: EventChannel, UserAttribute, Network, "
      "Gateway, Component, Placement, Route, Publisher, Subscriber|"
      "b.xml:3: <SubjectUID>: '2' is not right: it must be 0x and up to 16 hexadecimal digits|"
      "c.xml:2: <EventChannel>: not well-formed XML: </EventChanel> in line 2 is not spelt like "
      "the "
      "start tag <EventChannel> of line 1: write </EventChannel>, or correct the start tag");
}

TEST_F(Include, TellsCrossedTagsFromOnesThatNothingHasOpened) {
  file("b.xml", "<EventChannel name=\"b\">\n<SubjectUID>0x2</EventChannel></SubjectUID>");
  file("c.xml", "<EventChannel name=\"c\">\n<SubjectUID>0x3</Zebra></EventChannel>");
  EXPECT_EQ(problems_of(include("b.xml") + include("c.xml")),
            "b.xml:2: <SubjectUID>: not well-formed XML: </EventChannel> in line 2 closes "
            "<SubjectUID> of line 2: </SubjectUID> has to come first|"
            "c.xml:2: <SubjectUID>: not well-formed XML: </Zebra> in line 2 has no start tag: "
            "<SubjectUID> of line 2 is open, and ends with </SubjectUID>");
}

TEST_F(Include, LeavesNothingOpenOfAFileThatBreaksOff) {
  file("b.xml", "<Gateway name=\"g\"><Port network=\"air\"><Interface");
  file("c.xml", "<EventChannel name=\"c\"><Zebra><Zebra>");
  const auto said = problems_of(include("b.xml") + channel("a", 1) + include("c.xml") +
                                "<Network name=\"air\"><Kind>other</Kind><Kind/></Network>");
  EXPECT_TRUE(said.starts_with("s.xml:5: <Kind>: is one too many")) << said;
  EXPECT_EQ(std::ranges::count(said, '|'), 3) << said;
}

TEST_F(Include, RefusesWhatIsNoLocalFile) {
  const std::string right =
      "is not right: it must be the path of a local file, relative to this one or absolute";
  const std::string at = "s.xml:2: <include>: attribute href";
  EXPECT_EQ(problems_of(include("http://example.com/b.xml")),
            at + ": 'http://example.com/b.xml' " + right);
  EXPECT_EQ(problems_of(include("file:///etc/b.xml")), at + ": 'file:///etc/b.xml' " + right);
  EXPECT_EQ(problems_of(include("//host/b.xml")), at + ": '//host/b.xml' " + right);
  EXPECT_EQ(problems_of(include("b.xml#xpointer(/1)")),
            at + ": 'b.xml#xpointer(/1)' names a part of a file: only a whole one is included (%23 "
                 "stands for #)");
  EXPECT_EQ(problems_of(include("b.xml?x")),
            at + ": 'b.xml?x' has a query: it must be the path of a local file (%3F stands for ?)");
  for (const std::string href : {"b%2", "b%", "b%zz", "b%00", "b%+1"})
    EXPECT_EQ(
        problems_of(include(href)),
        at + ": '" + href + "' is not right: % is followed by two hexadecimal digits, not 00");
  EXPECT_EQ(problems_of(include("")), at + " is empty: it names the file");
  EXPECT_EQ(problems_of("<xi:include/>\n"), at + " is missing: it names the file");
  EXPECT_EQ(problems_of(include("none.xml")),
            "s.xml:2: <include>: none.xml: cannot open the file: No such file or directory");
  EXPECT_EQ(problems_of(include("/dev/null")),
            "s.xml:2: <include>: /dev/null: not a regular file: a description must be one");
}

TEST_F(Include, RefusesWhatAPlainProcessorWouldDoDifferently) {
  file("b.xml", channel("b", 2));
  const std::string at = "s.xml:2: <include>: ";
  const auto with = [&](const std::string& more, const std::string& content) {
    return problems_of("<xi:include href=\"b.xml\"" + more + ">" + content + "</xi:include>\n");
  };
  EXPECT_EQ(with("", ""), "");
  EXPECT_EQ(with(" parse=\"xml\"", " <!-- --> "), "");
  EXPECT_EQ(with(" parse=\"text\"", ""),
            at + "attribute parse: 'text' is not read, only XML is: remove it");
  EXPECT_EQ(with(" xpointer=\"x\"", ""),
            at + "attribute xpointer is not read: a file is included as a whole");
  EXPECT_EQ(with(" accept=\"x\"", ""), at + "attribute accept is not known: xi:include has href");
  EXPECT_EQ(with("", "<xi:fallback/>"),
            "s.xml:2: <fallback>: is not known here: xi:include is "
            "empty, and a file that is missing is an error");
  EXPECT_EQ(with("", "x"), at + "holds text, which has no meaning here: its content goes into "
                                "elements");
  EXPECT_EQ(
      with(" xml:base=\"c/\"", ""),
      at + "is not read inside of xml:base: remove that, and give href relative to this file");
  EXPECT_EQ(problems_of("<xi:fallback/>\n").substr(0, 40),
            "s.xml:2: <fallback>: is not known here: ");
  file("s.xml", "<System name=\"test\" xml:base=\"c/\" " + std::string(kSpace) + ">\n" +
                    include("b.xml") + "</System>");
  EXPECT_EQ(problems(), at + "is not read inside of xml:base: remove that, and give href relative "
                             "to this file");
}

TEST_F(Include, StandsOnlyWherePartsStand) {
  EXPECT_EQ(
      problems_of("<Network name=\"air\"><Kind>mesh</Kind>\n" + include("b.xml") + "</Network>\n"),
      "s.xml:3: <include>: xi:include is a child of System or Component: it stands for a "
      "whole part");
  file("s.xml", fmt::format("<xi:include {} href=\"b.xml\"/>", kSpace));
  EXPECT_EQ(problems(), "s.xml:1: <include>: the root element must be System, without a namespace");
}

TEST_F(Include, BringsOnlyWhatMayStandThere) {
  file("system.xml", "<System name=\"other\"/>");
  EXPECT_EQ(
      problems_of(include("system.xml")),
      "system.xml:1: <System>: a System cannot be included: the root of an included file is a "
      "part of one");
  file("net.xml", "<Network name=\"air\"><Kind>mesh</Kind></Network>");
  EXPECT_EQ(problems_of("<Component name=\"c\">" + include("net.xml") + "</Component>"),
            "net.xml:1: <Network>: is not known here; known: Description, EventChannel, Publisher, "
            "Subscriber");
}

TEST_F(Include, NamesTheChainOfFilesThatIncludeEachOther) {
  file("b.xml", fmt::format("<Component name=\"b\" {}>{}</Component>", kSpace, include("c.xml")));
  file("c.xml", fmt::format("<Component name=\"c\" {}>\n{}</Component>", kSpace, include("b.xml")));
  file("s.xml", system_of(include("b.xml") + include("./s.xml")));
  EXPECT_EQ(problems(),
            "s.xml:3: <include>: a file cannot include itself: s.xml includes ./s.xml|"
            "c.xml:1: <Component>: is not known here; known: Description, EventChannel, Publisher, "
            "Subscriber");
  file("d.xml",
       fmt::format("<Component name=\"b\" {}>\n\n{}</Component>", kSpace, include("d.xml")));
  EXPECT_EQ(problems_of(include("d.xml")),
            "d.xml:3: <include>: a file cannot include itself: d.xml includes d.xml");
}

TEST_F(Include, AllowsSoManyFilesAndNoMore) {
  file("b.xml", "<Subscriber channel=\"a\" network=\"air\"/>");
  std::string parts = "<Network name=\"air\"><Kind>mesh</Kind></Network>\n" + channel("a", 1);
  for (int i = 0; i < 1023; ++i) parts += include("b.xml");
  EXPECT_EQ(problems_of(parts), "");
  EXPECT_EQ(problems_of(parts + include("b.xml")),
            "s.xml:1027: <include>: more than 1024 files are included; that is the limit");
}

TEST_F(Include, CountsTheBytesOfAllFilesTogether) {
  file("b.xml", channel("b", 1) + std::string(1U << 20U, ' '));
  file("c.xml", channel("c", 2));
  std::filesystem::resize_file(path("c.xml"), (256U << 20U) - (1U << 19U));
  EXPECT_EQ(problems_of(include("b.xml") + include("c.xml")),
            "s.xml:3: <include>: the files of the description have more than 268435456 bytes; that "
            "is the limit");
}

TEST_F(Include, IsRefusedInATextWithoutAFolder) {
  file("b.xml", channel("b", 1));
  const auto xml = system_of(include("b.xml"));
  const auto without = read_memory(xml, "t.xml");
  ASSERT_FALSE(without);
  EXPECT_EQ(said(without.error(), ""),
            "t.xml:2: <include>: a text that is no file includes none: there is nothing that href "
            "is relative to");
  const auto with = read_memory(xml, "t.xml", path(""));
  ASSERT_TRUE(with) << said(with.error(), "");
  EXPECT_EQ(with->channels.size(), 1U);
}

TEST_F(Include, HasItsWayOfSayingAnIdForTools) {
  file("s.xml", system_of(include("none.xml") + "<Zebra/>"));
  const auto result = read(path("s.xml"));
  ASSERT_FALSE(result);
  ASSERT_EQ(result.error().size(), 2U);
  EXPECT_EQ(result.error()[0].id, core::FindingId::unreadable);
  EXPECT_EQ(result.error()[1].id, core::FindingId::not_in_schema);
}

class Examine : public Include {};

TEST_F(Examine, ReadsFurtherFilesAsPartsOfTheSystem) {
  file("s.xml", system_of(channel("a", 1)));
  file("b.xml", channel("b", 2));
  file("c.xml", channel("a", 3));
  const auto good = examine({path("s.xml"), path("b.xml")});
  EXPECT_TRUE(good.readable);
  EXPECT_EQ(said(good.problems, ""), "");
  EXPECT_EQ(channels(good.system), (Names{"a s.xml:2", "b b.xml:1"}));
  const auto twice = examine({path("s.xml"), path("b.xml"), path("c.xml")});
  EXPECT_TRUE(twice.readable);
  ASSERT_EQ(twice.problems.size(), 1U);
  EXPECT_EQ(twice.problems[0].file, path("c.xml"));
  const auto second = examine({path("s.xml"), path("s.xml")});
  EXPECT_FALSE(second.readable);
  EXPECT_EQ(
      said(second.problems, path("")),
      "s.xml:1: <System>: a System cannot be included: the root of an included file is a part "
      "of one");
}

TEST_F(Examine, GoesOnToTheNextFileAfterABrokenOne) {
  file("s.xml", "<System name=\"test\"><");
  file("b.xml", "<EventChannel name=\"b\"/>");
  const auto result = examine({path("s.xml"), path("none.xml"), path("b.xml")});
  EXPECT_FALSE(result.readable);
  ASSERT_EQ(result.problems.size(), 3U);
  EXPECT_EQ(result.problems[0].file, path("s.xml"));
  EXPECT_EQ(to_string(result.problems[1]),
            path("none.xml") + ": cannot open the file: No such file or directory");
  EXPECT_EQ(result.problems[2].text, "is not complete: it needs SubjectUID");
}

TEST_F(Examine, ReportsItsProgress) {
  std::string parts;
  for (int i = 0; i < 50000; ++i) parts += channel(fmt::format("c{}", i), i + 1);
  file("s.xml", system_of(parts));
  const auto size = std::filesystem::file_size(path("s.xml"));
  std::uint64_t before = 0;
  int calls = 0;
  const auto result = examine({path("s.xml")}, [&](std::uint64_t bytes, std::uint64_t total) {
    EXPECT_EQ(total, size);
    EXPECT_GE(bytes, before);
    before = bytes;
    ++calls;
  });
  EXPECT_TRUE(result.readable);
  EXPECT_EQ(before, size);
  EXPECT_EQ(calls, static_cast<int>(size >> 20U) + 1) << "each MiB, and the end";
}

TEST_F(Examine, ChecksAPartAlone) {
  EXPECT_TRUE(check_part(file("b.xml", channel("b", 2))).empty());
  EXPECT_TRUE(check_part(file("s.xml", system_of(channel("b", 2)))).empty());
  EXPECT_EQ(
      said(check_part(file("c.xml", "<EventChannel name=\"1\"/>")), path("")),
      "c.xml:1: <EventChannel>: attribute name: '1' is not right: it must be a letter, then up "
      "to 62 letters, digits, dots, underscores or hyphens|"
      "c.xml:1: <EventChannel>: is not complete: it needs SubjectUID");
  EXPECT_EQ(said(check_part(file("d.xml", "<Port/>")), path("")),
            "d.xml:1: <Port>: the root element must be System or a part of one, without a "
            "namespace");
}

/// Of s.xml in a folder.
Sha256::Digest digest_of(const std::string& file) {
  Sha256::Digest digest{};
  EXPECT_TRUE(read(file, Users::any, &digest)) << file;
  return digest;
}

TEST_F(Include, WhatIsReadHasOneDigestWhereverItIs) {
  const std::string whole = system_of(include("parts/c.xml"));
  for (const std::string folder : {"a", "b", "c"}) {
    file(folder + "/s.xml", whole);
    file(folder + "/parts/c.xml", channel("one", folder == "c" ? 2 : 1));
  }
  EXPECT_EQ(digest_of(path("a/s.xml")), digest_of(path("b/s.xml")));
  EXPECT_NE(digest_of(path("a/s.xml")), digest_of(path("c/s.xml"))) << "what is included counts";
  file("b/s.xml", whole + "<!-- -->\n");
  EXPECT_NE(digest_of(path("a/s.xml")), digest_of(path("b/s.xml")));
}

}  // namespace
}  // namespace mlcca::description
