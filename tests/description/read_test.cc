// SPDX-License-Identifier: BSD-2-Clause
// What no file of the corpus can show: limits from both sides, files that are none, hostile sizes.
#include "description/read.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string>

#include "description/grammar.hpp"
#include "description/problems.hpp"
#include "description/xml.hpp"

namespace mlcca::description {
namespace {

std::string system_of(const std::string& parts) {
  return "<System name=\"test\">\n" + parts + "</System>\n";
}

std::string channels(int count) {
  std::string out;
  for (int i = 0; i < count; ++i)
    out += fmt::format(
        "<EventChannel name=\"c{0}\"><SubjectUID>{1:#x}</SubjectUID></EventChannel>\n", i, i + 1);
  return out;
}

std::string networks(int count) {
  std::string out;
  for (int i = 0; i < count; ++i)
    out += fmt::format("<Network name=\"n{0}\"><Kind>mesh</Kind></Network>\n", i);
  return out;
}

std::string gateways(int count) {
  std::string out;
  for (int i = 0; i < count; ++i)
    out += fmt::format(
        "<Gateway name=\"g{0}\"><Port network=\"n0\"><Interface name=\"w{0}\"/></Port></Gateway>\n",
        i);
  return out;
}

/// The only problem, as text; "" if there is none, all of them if there are several.
std::string problem_of(const std::string& xml) {
  const auto result = read_memory(xml, "t.xml");
  if (result) return "";
  std::string out;
  for (const auto& p : result.error()) out += (out.empty() ? "" : "\n") + to_string(p);
  return out;
}

TEST(Limits, AllowSoManyChannelsAndNoMore) {
  EXPECT_EQ(problem_of(system_of(channels(262144))), "");
  EXPECT_EQ(problem_of(system_of(channels(262145))),
            "t.xml:262146: <EventChannel>: 262145 channels are too many: at most 262144");
}

TEST(Limits, AllowSoManyNetworksAndNoMore) {
  EXPECT_EQ(problem_of(system_of(networks(1024))), "");
  EXPECT_EQ(problem_of(system_of(networks(1025))),
            "t.xml:1026: <Network>: 1025 networks are too many: at most 1024");
}

TEST(Limits, AllowSoManyGatewaysAndNoMore) {
  EXPECT_EQ(problem_of(system_of(networks(1) + gateways(256))), "");
  EXPECT_EQ(problem_of(system_of(networks(1) + gateways(257))),
            "t.xml:259: <Gateway>: 257 gateways are too many: at most 256");
}

std::string mesh(const std::string& attributes, const std::string& parts) {
  return system_of("<Network name=\"n\"><Kind>mesh</Kind><Mesh " + attributes + ">\n" + parts +
                   "</Mesh></Network>\n");
}

/// Each on a line of its own, from line 3 of a mesh() on.
std::string nodes(int count) {
  std::string out;
  for (int i = 0; i < count; ++i)
    out += fmt::format("<Node name=\"n{}\" address=\"10.0.{}.{}\"/>\n", i, i / 256, i % 256);
  return out;
}

TEST(Limits, AllowSoManyNodesOfAMeshAndNoMore) {
  EXPECT_EQ(problem_of(mesh("", nodes(4096))), "");
  EXPECT_EQ(problem_of(mesh("", nodes(4097))),
            "t.xml:4099: <Node>: 4097 nodes of mesh n are too many: at most 4096");
}

TEST(Limits, AllowSoManyLinksOfAMeshAndNoMore) {
  // 512 nodes have 130816 pairs: enough for each link to be another one.
  const auto with = [](int links, const char* both_ways) {
    std::string parts = nodes(512);
    for (int from = 0, made = 0; made < links; ++from)
      for (int to = from + 1; to < 512 && made < links; ++to, ++made)
        parts += fmt::format("<Link from=\"n{}\" to=\"n{}\" rate=\"1\" both-ways=\"{}\"/>\n", from,
                             to, both_ways);
    return problem_of(mesh("", parts));
  };
  EXPECT_EQ(with(8192, "false"), "");
  EXPECT_EQ(with(8193, "false"),
            "t.xml:8707: <Link>: 8193 links of mesh n are too many: at most 8192");
  EXPECT_EQ(with(4096, "true"), "");
  EXPECT_EQ(with(4097, "true"),
            "t.xml:4611: <Link>: 8194 links of mesh n are too many: at most 8192");
}

TEST(Limits, AllowSoManyDomainsOfAMeshAndNoMore) {
  const auto with = [](int domains, int members) {
    std::string parts = nodes(2);
    for (int i = 0; i < domains; ++i) {
      parts += fmt::format("<Domain name=\"d{}\">", i);
      for (int m = 0; m < members; ++m) parts += "<Member from=\"n0\" to=\"n1\"/>";
      parts += "</Domain>\n";
    }
    return problem_of(mesh("interference=\"explicit\"", parts));
  };
  EXPECT_EQ(with(1024, 8), "");
  EXPECT_EQ(with(1025, 0),
            "t.xml:1029: <Domain>: 1025 domains of mesh n are too many: at most 1024");
  EXPECT_EQ(with(1, 8193),
            "t.xml:2: <Mesh>: 8193 members of its domains are too many: at most 8192");
}

TEST(Limits, AllowSoManySourcesOfAMeshAndNoMore) {
  const auto with = [](int sources) {
    std::string parts;
    for (int i = 0; i < sources; ++i)
      parts += fmt::format("<Source kind=\"wire\" interface=\"eth{}\"/>\n", i);
    return problem_of(mesh("", parts));
  };
  EXPECT_EQ(with(16), "");
  EXPECT_EQ(with(17), "t.xml:19: <Source>: 17 sources of mesh n are too many: at most 16");
}

/// The path of a socket with that many bytes.
std::string socket_problem(std::size_t bytes) {
  return problem_of(
      mesh("", "<Source kind=\"babel\" endpoint=\"/" + std::string(bytes - 1, 's') + "\"/>\n"));
}

TEST(Limits, AllowASocketPathThatTheKernelCanHoldAndNoLonger) {
  EXPECT_EQ(socket_problem(107), "");
  EXPECT_NE(socket_problem(108), "");
}

TEST(Limits, AllowSoManyPairsOfAChannelAndNoMore) {
  const auto with = [](int publishers) {
    std::string parts = networks(1) + channels(1);
    for (int i = 0; i < publishers; ++i) parts += "<Publisher channel=\"c0\" network=\"n0\"/>\n";
    for (int i = 0; i < 512; ++i) parts += "<Subscriber channel=\"c0\" network=\"n0\"/>\n";
    return problem_of(system_of(parts));
  };
  EXPECT_EQ(with(512), "");
  EXPECT_EQ(with(513),
            "t.xml:3: <EventChannel>: 513 publishers and 512 subscribers of channel c0 are too "
            "many: at most 262144 pairs");
}

TEST(Limits, AllowSoManyBytesAndNoMore) {
  const std::string comment = "<!--" + std::string((1U << 20U) - 7, 'x') + "-->";  // 1 MiB
  auto xml = system_of("");
  while (xml.size() + comment.size() < 268435456) xml += comment;
  xml.resize(268435456, ' ');
  EXPECT_EQ(problem_of(xml), "");
  xml += ' ';
  EXPECT_EQ(problem_of(xml),
            "t.xml: the files of the description have more than 268435456 bytes; that is the "
            "limit");
}

TEST(Limits, AllowALongValueAndNoLonger) {
  // Neither is a Name, but only the second is too long to be looked at.
  const auto with = [](std::size_t bytes) {
    return problem_of("<System name=\"" + std::string(bytes, 'x') + "\"/>");
  };
  EXPECT_EQ(with(65536), "t.xml:1: <System>: attribute name: '" + std::string(80, 'x') +
                             "…' is not right: it must be a letter, then up to 62 letters, digits, "
                             "dots, underscores or hyphens");
  EXPECT_EQ(with(65537),
            "t.xml:1: <System>: attribute name is longer than 65536 bytes; that is the limit");
}

TEST(Limits, AllowALongTextAndNoLonger) {
  const auto with = [](std::size_t bytes, const std::string& blanks) {
    return problem_of(system_of("<Network name=\"n\"><Kind>\n" + blanks + std::string(bytes, 'x') +
                                "</Kind></Network>"));
  };
  const std::string shown = "t.xml:2: <Kind>: '" + std::string(80, 'x') + "…' is not one of ";
  EXPECT_TRUE(with(65536, "").starts_with(shown));
  EXPECT_TRUE(with(65536, std::string(200000, ' ')).starts_with(shown)) << "blanks do not count";
  EXPECT_EQ(with(65537, ""), "t.xml:2: <Kind>: is longer than 65536 bytes; that is the limit");
}

std::string with_attributes(std::size_t count) {
  std::string xml = "<System name=\"test\">\n<x";
  for (std::size_t i = 0; i < count; ++i) xml += " a" + std::to_string(i) + "='>'";
  return xml + "/></System>";
}

TEST(Limits, AllowSoManyAttributesAndNoMore) {
  EXPECT_EQ(problem_of(with_attributes(64)).find("limit"), std::string::npos);
  const std::string refused = "t.xml:2: an element has more than 64 attributes; that is the limit";
  EXPECT_EQ(problem_of(with_attributes(65)), refused);
  // Compared each with each they would take minutes.
  EXPECT_EQ(problem_of(with_attributes(1'000'000)), refused);
}

TEST(Limits, CountAttributesOfOneElementOnly) {
  std::string parts;
  for (int i = 0; i < 100; ++i)
    parts += "<!-- a=1 --><?b c=1 ?><Network name=\"n" + std::to_string(i) +
             "\"><Kind><![CDATA[can]]></Kind><Description>a=1 > b=2</Description></Network>";
  EXPECT_EQ(problem_of(system_of(parts)).find("limit"), std::string::npos);
}

TEST(Limits, AreFarFromWhatTheGrammarAllows) {
  for (const auto* type : element_types())
    EXPECT_LE(type->keys.size(), kMaxAttributes / 2) << type->name;
}

TEST(Limits, AllowNoNulAnywhere) {
  const std::string text = "\n<?a?>";
  const std::string xml = "<System name=\"test\">\n</System>" + text;
  for (std::size_t at = 4; at <= xml.size(); ++at) {
    std::string with = xml;
    with.insert(at, 1, '\0');
    const auto line = 1 + std::ranges::count(with.substr(0, at), '\n');
    EXPECT_EQ(problem_of(with), "t.xml:" + std::to_string(line) +
                                    ": not well-formed XML: a NUL byte is no character; save the "
                                    "file as text")
        << at;
  }
}

TEST(Limits, AllowElementsSoDeepAndNoDeeper) {
  const auto nested = [](int depth) {
    std::string xml = "<System name=\"test\">";
    for (int i = 1; i < depth; ++i) xml += "<x>";
    for (int i = 1; i < depth; ++i) xml += "</x>";
    return problem_of(xml + "</System>");
  };
  EXPECT_EQ(nested(256).find("deeper"), std::string::npos);
  EXPECT_NE(nested(257).find("is nested deeper than 256 elements"), std::string::npos);
}

TEST(Limits, AllowSoManyElementsAndAttributesAndNoMore) {
  // The root and its name are two; an unknown part costs one, its own problem, and then its
  // content.
  const auto with = [](int inside) {
    std::string xml = "<System name=\"test\"><x>";
    for (int i = 0; i < inside; ++i) xml += "<a/>";
    return xml + "</x></System>";
  };
  EXPECT_EQ(problem_of(with(16777216 - 3)).find("16777216"), std::string::npos);
  EXPECT_NE(problem_of(with(16777216 - 2))
                .find("the description has more than 16777216 elements and attributes; that is the "
                      "limit"),
            std::string::npos);
}

TEST(Limits, AreNotReachedByManyUnknownNames) {
  std::string parts = channels(4096);
  for (int i = 0; i < 100000; ++i) parts += "<Publisher channel=\"c409x\" network=\"n\"/>\n";
  const auto result = read_memory(system_of(parts), "t.xml");
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().size(), 1001U);
  EXPECT_EQ(result.error().back().line, 0);
  EXPECT_EQ(result.error().back().text, "there are more problems than these: repair them first");
}

TEST(Limits, AreSaidOfAHugeGatewayToo) {
  std::string ports;
  for (int i = 0; i < 150000; ++i)
    ports += fmt::format("<Port network=\"n0\"><Interface name=\"w{}\"/></Port>\n", i);
  const auto result = read_memory(
      system_of(networks(1) + "<Gateway name=\"g\">\n" + ports + "</Gateway>"), "t.xml");
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().size(), 1001U);
}

TEST(Problems, ShowNoMoreOfALongValueThanAPersonReads) {
  const auto with = [](std::size_t length) {
    return problem_of(
        system_of("<Network name=\"n\"><Kind>" + std::string(length, 'x') + "</Kind></Network>"));
  };
  EXPECT_EQ(with(80),
            "t.xml:2: <Kind>: '" + std::string(80, 'x') +
                "' is not one of can, udp-multicast, udp-broadcast, mesh, ieee802154, other");
  EXPECT_EQ(with(81),
            "t.xml:2: <Kind>: '" + std::string(80, 'x') +
                "…' is not one of can, udp-multicast, udp-broadcast, mesh, ieee802154, other");
}

TEST(Problems, AreCutAtWholeCharactersAndCleaned) {
  Problems problems("t.xml");
  problems.add(1, "", std::string(479, 'x') + "ä");
  problems.add(2, "a\x1b[b", "c\x7f\n\td");
  const auto found = problems.take();
  EXPECT_EQ(found[0].text, std::string(479, 'x') + "…");
  EXPECT_EQ(found[1].element, "a [b");
  EXPECT_EQ(found[1].text, "c   d");
}

TEST(Problems, HaveTheirLineBeyond65535) {
  EXPECT_EQ(problem_of(system_of(std::string(70000, '\n') + "<Network name=\"n\"/>\n")),
            "t.xml:70002: <Network>: is not complete: it needs Kind");
  EXPECT_EQ(problem_of(system_of(std::string(70000, '\n') +
                                 "<Network name=\"n\"><Kind>can</Kind></Network>\n")),
            "t.xml:70002: <Network>: a CAN network needs a Profile: raw, famouso, "
            "j1939, cyphal or canopen");
}

TEST(Problems, AreShownUpToTheThousandthAndThenSaidToBeMore) {
  std::string parts;
  for (int i = 0; i < 1000; ++i) parts += "<x/>\n";
  const auto all = read_memory(system_of(parts), "t.xml");
  ASSERT_FALSE(all);
  EXPECT_EQ(all.error().size(), 1000U);
  EXPECT_EQ(all.error().back().line, 1001);
  const auto more = read_memory(system_of(parts + "<x/>\n"), "t.xml");
  ASSERT_FALSE(more);
  EXPECT_EQ(more.error().size(), 1001U);
  EXPECT_EQ(more.error().back().text, "there are more problems than these: repair them first");
}

TEST(Problems, PrintNothing) {
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();
  for (const std::string xml :
       {"", "<", "<System", "\xff\xfe<\0S", "<?xml version='1.0' encoding='x'?><S/>",
        "<!DOCTYPE a [<!ENTITY % b SYSTEM 'c'> %b;]><a/>", "<System name='a'>\xff"})
    EXPECT_FALSE(read_memory(xml, "t.xml")) << xml;
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
}

TEST(ReadMemory, RefusesWhatIsNoUtf8Xml) {
  EXPECT_EQ(problem_of(""), "t.xml:1: the file is empty: a root element is needed");
  EXPECT_EQ(problem_of(" \n"), "t.xml:1: the file is empty: a root element is needed");
  EXPECT_EQ(problem_of("name: volksbot"),
            "t.xml:1: this is not XML in UTF-8: the first character must be '<'");
  const auto in = [](const std::string& encoding) {
    return "t.xml:1: this is text in " + encoding +
           ", and a description is read in UTF-8: save it in UTF-8, or convert it (iconv -f " +
           encoding + " -t UTF-8), and let its XML declaration name no other encoding";
  };
  EXPECT_EQ(problem_of(std::string("<\0S\0y\0", 6)), in("UTF-16LE"));
  EXPECT_EQ(problem_of(std::string("\0<\0S\0y", 6)), in("UTF-16BE"));
  EXPECT_EQ(problem_of(std::string("\xff\xfe<\0S\0", 6)), in("UTF-16"));
  EXPECT_EQ(problem_of(std::string("\xfe\xff\0<\0S", 6)), in("UTF-16"));
  EXPECT_EQ(problem_of(std::string("\xff\xfe\0\0<\0\0\0", 8)), in("UTF-32"));
  EXPECT_EQ(problem_of(std::string("<\0\0\0S\0\0\0", 8)), in("UTF-32LE"));
  EXPECT_EQ(problem_of("\xef\xbb\xbf<System name=\"test\"/>"), "");
}

TEST(ReadMemory, MistakesInCommentsAreReportedAtTheirLine) {
  EXPECT_EQ(problem_of("<System name='a'>\n<!-- open\n\n<Network/>\n</System>\n"),
            "t.xml:2: <System>: not well-formed XML: the comment that begins here does not end: "
            "\"-->\" is missing");
  EXPECT_EQ(problem_of("<System name='a'>\n<!-- good -->\n<!-- one\n-- two -->\n</System>\n"),
            "t.xml:4: <System>: not well-formed XML: \"--\" within a comment, which begins in line "
            "3: only \"-->\", its end, may have two hyphens; write one, or end the comment before");
  EXPECT_EQ(
      problem_of("<System name='a'>\n<!-- a --->\n</System>\n"),
      "t.xml:2: <System>: not well-formed XML: \"--\" within a comment: only \"-->\", its end, "
      "may have two hyphens; write one, or end the comment before");
}

TEST(ReadMemory, AnElementThatComesTooLateIsReportedWithItsPlace) {
  EXPECT_EQ(problem_of("<System name='a'>\n<EventChannel name='c'>\n<SubjectUID>0x1</SubjectUID>\n"
                       "<Attributes/>\n<Description>d</Description>\n</EventChannel>\n</System>\n"),
            "t.xml:5: <Description>: comes too late: it belongs before Attributes in line 4, "
            "and here may stand Attributes: EventChannel has SubjectUID, Description, "
            "Attributes, in this order");
}

TEST(ReadMemory, OfAChoiceItDoesNotDemandAnOrder) {
  EXPECT_EQ(problem_of("<System name='a'>\n<Component name='c'>\n<Publisher channel='x'/>\n"
                       "<Description>d</Description>\n</Component>\n</System>\n"),
            "t.xml:4: <Description>: comes too late: it belongs before Publisher in line 3, and "
            "here may stand one of EventChannel, Publisher, Subscriber: Component has "
            "Description, then EventChannel, Publisher, Subscriber in any order");
}

TEST(ReadMemory, AMistakeInATagOfSeveralLinesIsToldAtItsLine) {
  EXPECT_EQ(problem_of("<System name='a'>\n<EventChannel\n name='c'\n\n colour='red'\n>\n"
                       "<SubjectUID>0x1</SubjectUID>\n</EventChannel>\n</System>\n")
                .substr(0, 24),
            "t.xml:5: <EventChannel>:");
  EXPECT_EQ(problem_of("<System name='a'>\n<EventChannel\n name='c'\n safe-side=\n'left'\n>\n"
                       "<SubjectUID>0x1</SubjectUID>\n</EventChannel>\n</System>\n")
                .substr(0, 24),
            "t.xml:5: <EventChannel>:");
  EXPECT_EQ(problem_of("<System name='a'>\n<Publisher\n\n\n/>\n</System>\n"),
            "t.xml:2: <Publisher>: attribute channel is missing");
}

TEST(ReadMemory, TheLineOfAnElementIsThatOfItsName) {
  const auto system = read_memory(
      "<System name='a'>\n<EventChannel\n name='c'\n>\n"
      "<SubjectUID>0x1</SubjectUID>\n</EventChannel>\n</System>\n",
      "t.xml");
  ASSERT_TRUE(system);
  EXPECT_EQ(system->channels[0].origin.line, 2);
}

TEST(ReadMemory, ReadsTheSameTwice) {
  const auto xml = system_of(channels(3));
  const auto first = read_memory(xml, "t.xml");
  const auto second = read_memory(xml, "t.xml");
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->channels.size(), 3U);
  EXPECT_EQ(second->channels[2].subject, first->channels[2].subject);
  EXPECT_EQ(second->files.at(second->channels[2].origin.file), "t.xml");
  EXPECT_EQ(second->channels[2].origin.line, 4);
}

class ReadFile : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string form = ::testing::TempDir() + "mlcca-read-XXXXXX";
    ASSERT_NE(mkdtemp(form.data()), nullptr);
    folder_ = form;
  }
  void TearDown() override {
    unlink(path().c_str());
    rmdir(folder_.c_str());
  }
  [[nodiscard]] std::string path() const { return folder_ + "/system.xml"; }
  [[nodiscard]] std::string problem() const {
    const auto result = read(path());
    if (result) return "";
    EXPECT_EQ(result.error().size(), 1U);
    return to_string(result.error().front());
  }

 private:
  std::string folder_;
};

TEST_F(ReadFile, ReadsAFile) {
  std::ofstream(path()) << system_of(channels(2));
  EXPECT_EQ(problem(), "");
}

TEST_F(ReadFile, SaysThatThereIsNone) {
  EXPECT_EQ(problem(), path() + ": cannot open the file: No such file or directory");
}

TEST_F(ReadFile, RefusesAFolder) {
  const auto result = read("tests");
  ASSERT_FALSE(result);
  EXPECT_EQ(to_string(result.error()[0]), "tests: not a regular file: a description must be one");
}

TEST_F(ReadFile, RefusesAFifoWithoutWaitingForAWriter) {
  ASSERT_EQ(mkfifo(path().c_str(), 0600), 0);
  EXPECT_EQ(problem(), path() + ": not a regular file: a description must be one");
}

TEST_F(ReadFile, RefusesADevice) {
  const auto result = read("/dev/zero");
  ASSERT_FALSE(result);
  EXPECT_EQ(to_string(result.error()[0]),
            "/dev/zero: not a regular file: a description must be one");
}

TEST_F(ReadFile, ReadsNoMoreOfAHugeFileThanItMust) {
  std::ofstream(path()) << "<";
  ASSERT_EQ(truncate(path().c_str(), off_t{1} << 40), 0);
  EXPECT_EQ(problem(), path() +
                           ": the files of the description have more than 268435456 bytes; that is "
                           "the limit");
}

TEST(ToString, LeavesOutWhatIsUnknown) {
  EXPECT_EQ(to_string({"f.xml", 3, "Port", "bad"}), "f.xml:3: <Port>: bad");
  EXPECT_EQ(to_string({"f.xml", 3, "", "bad"}), "f.xml:3: bad");
  EXPECT_EQ(to_string({"f.xml", 0, "", "bad"}), "f.xml: bad");
}

}  // namespace
}  // namespace mlcca::description
