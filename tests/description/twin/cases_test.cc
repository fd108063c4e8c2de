// SPDX-License-Identifier: BSD-2-Clause
// Systems of one rule each, whose comments say what is found, and what the twin says of input that
// it cannot check.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include "core/design/findings.hpp"
#include "description/read.hpp"
#include "tests/description/twin/expected.hpp"
#include "tests/description/twin/twin.hpp"

namespace mlcca::testing {
namespace {

std::vector<std::string> cases() {
  std::vector<std::string> out;
  for (const auto& entry : std::filesystem::directory_iterator("tests/description/twin/cases"))
    out.push_back(entry.path().string());
  std::ranges::sort(out);
  return out;
}

TEST(TwinCases, FindWhatTheirCommentsSay) {
  const auto files = cases();
  ASSERT_GE(files.size(), 25U);
  const auto found = twin_findings(files);
  for (std::size_t i = 0; i < files.size(); ++i)
    EXPECT_EQ(listed(found[i]), listed(expected_in(text_of(files[i])))) << files[i];
}

TEST(TwinCases, AreDecidedAlikeByTheChecker) {
  for (const auto& file : cases()) {
    const auto text = text_of(file);
    if (text.contains("of the twin alone")) continue;
    const auto system = description::read(file);
    ASSERT_TRUE(system) << description::to_string(system.error()[0]);
    EXPECT_EQ(listed(findings_of(*system)), listed(in_words(*system, expected_in(text)))) << file;
  }
}

TEST(TwinCases, FitTheSchema) {
  for (const auto& file : cases())
    output_of("xmllint --noout --nonet --schema description/system.xsd '" + file + "' 2>&1");
}

/// The stylesheet says a number where it finds something: with the severity of the table's row.
TEST(TwinCases, NameFindingsAsTheTableDoes) {
  std::map<std::string, core::Severity> kinds;
  for (const auto& info : core::finding_table())
    kinds.emplace(core::code_of(info.id), info.severity);
  const std::map<std::string, core::Severity> words = {{"finding", core::Severity::error},
                                                       {"compare", core::Severity::error},
                                                       {"sense", core::Severity::note}};
  const std::regex call(
      "call-template name=\"([a-z]+)\">\\s*<xsl:with-param name=\"id\" select=\"'(MLCCA[0-9]+)'");
  const std::regex any("MLCCA[0-9]{3}");
  std::size_t calls = 0;
  for (const auto& entry : std::filesystem::directory_iterator("description")) {
    if (entry.path().extension() != ".xsl") continue;
    const auto text = text_of(entry.path().string());
    for (std::sregex_iterator at(text.begin(), text.end(), any), end; at != end; ++at)
      EXPECT_TRUE(kinds.contains(at->str())) << entry.path() << " names " << at->str();
    for (std::sregex_iterator at(text.begin(), text.end(), call), end; at != end; ++at, ++calls) {
      ASSERT_TRUE(words.contains((*at)[1])) << (*at)[1];
      EXPECT_EQ(words.at((*at)[1]), kinds[(*at)[2]]) << entry.path() << " " << (*at)[2];
    }
  }
  EXPECT_GE(calls, 10U);
  EXPECT_EQ(kinds[core::code_of(core::FindingId::not_decided)], core::Severity::note);
}

constexpr const char* kCheck = "xsltproc --nonet description/check.xsl ";

/// The end of each output: what is left of every description, and the count.
std::string ended_with(int findings) {
  return "note MLCCA034: identifiers, lengths of frames, traffic that must be stated, and what "
         "reaches others on a network are not decided here: left to mlccactl check\n" +
         std::to_string(findings) + " findings\n";
}

TEST(Twin, FindsNamesThatLeadNowhere) {
  const Folder folder;
  const auto file = folder.add(
      "names.xml",
      "<System name='s'><EventChannel name='c'><SubjectUID>0x1</SubjectUID><Attributes>"
      "<Attribute><Name>Omision</Name><Value>1</Value></Attribute></Attributes></EventChannel>"
      "<Network name='n'><Kind>mesh</Kind></Network><Publisher channel='d' network='n'/>"
      "<Subscriber channel='0x2' network='m'/><Route from='n' to='o'/></System>");
  EXPECT_EQ(output_of(kCheck + file),
            "error MLCCA005: attribute Omision is not known\n"
            "error MLCCA005: channel d is not known\n"
            "error MLCCA005: channel 0x2 is not known\n"
            "error MLCCA005: place m of channel 0x2 is not known\n"
            "error MLCCA005: place o is not known\n" +
                ended_with(5));
}

TEST(Twin, FindsAnIncludeThatWasNotCarriedOut) {
  const Folder folder;
  const auto file = folder.add("include.xml",
                               "<System name='s' xmlns:xi='http://www.w3.org/2001/XInclude'>"
                               "<xi:include href='part.xml'/></System>");
  EXPECT_EQ(
      output_of(kCheck + file),
      "error MLCCA001: part.xml was not included: xsltproc needs -xinclude\n" + ended_with(1));
}

TEST(Twin, FindsARootThatIsNoSystem) {
  const Folder folder;
  const auto file = folder.add("part.xml", "<Component name='c'/>");
  EXPECT_EQ(output_of(kCheck + file),
            "error MLCCA003: the root element must be System\n1 findings\n");
}

TEST(Twin, SaysWhichConnectionsItDoesNotCheck) {
  EXPECT_EQ(
      output_of(kCheck + std::string("tests/description/twin/cases/route-undeclared.xml")),
      "note MLCCA034: publisher p, subscriber s: no Route is declared between a and b: left to "
      "mlccactl check\n" +
          ended_with(0));
}

TEST(Twin, SaysWhereALowerSetMayServeSomebodyAndWhatItDoesNotAddUp) {
  EXPECT_EQ(
      output_of(kCheck + std::string("tests/description/twin/cases/sets-partly.xml")),
      "note MLCCA034: publisher p, subscriber t: what the hops from n to m give together is not "
      "decided here, left to mlccactl check\n"
      "note MLCCA034: publisher p, subscriber s: no attribute set is right for all, and a lower "
      "one may be used for this: not decided here, left to mlccactl check\n"
      "note MLCCA034: hop n, attribute Bandwidth: what all channels need together is not added "
      "up: not decided here, left to mlccactl check\n"
      "note MLCCA034: hop m, attribute Bandwidth: what all channels need together is not added "
      "up: not decided here, left to mlccactl check\n" +
          ended_with(0));
}

TEST(Twin, SaysWhatItDoesNotDecideWhereNothingElseIsFound) {
  const auto note = [](const std::string& what) {
    return "note MLCCA034: publisher q, subscriber t, hop bus, attribute " + what +
           ", provided what is computed: not decided here, left to mlccactl check\n";
  };
  EXPECT_EQ(output_of(kCheck + std::string("tests/description/twin/cases/computed.xml")),
            "error MLCCA021: publisher p, subscriber s, hop bus, attribute Omission: required 2 "
            "events, provided 5 events\n" +
                note("Deadline: required 50000000 ns") + note("Period: required 50000000 ns") +
                ended_with(1));
}

TEST(Twin, LeavesWhatTheLinksOfAMeshGiveAndCarryToTheChecker) {
  const auto note = [](const std::string& what) {
    return "note MLCCA034: publisher p, subscriber s, hop mesh, attribute " + what +
           ", provided what is computed: not decided here, left to mlccactl check\n";
  };
  EXPECT_EQ(output_of(kCheck + std::string("tests/description/twin/cases/mesh-computed.xml")),
            note("Latency: required 50000000 ns") + note("Deadline: required 100000000 ns") +
                note("Period: required 100000000 ns") + note("Bandwidth: required 80 bytes/s") +
                note("MaxPayload: required 8 bytes") + ended_with(0));
}

TEST(Twin, SaysThatResponseTimesCanRefuteWhatIsStatedOfABus) {
  const auto note = [](const std::string& publisher) {
    return "note MLCCA034: publisher " + publisher +
           ", subscriber s, hop b, attribute Deadline: required 1000000 ns, provided what is "
           "computed: not decided here, left to mlccactl check\n";
  };
  const auto bus = [](const std::string& rates, const std::string& format) {
    const auto attribute = [](const std::string& name, const std::string& value) {
      return "<Attribute><Name>" + name +
             "</Name><Dimension><SIUnit><Seconds>1</Seconds></SIUnit><Magnitude>-6</Magnitude>"
             "</Dimension><Value>" +
             value + "</Value></Attribute>";
    };
    return "<System name='s'><EventChannel name='c'><SubjectUID>0x1</SubjectUID><Attributes>" +
           attribute("Period", "1000") +
           "</Attributes></EventChannel><Network name='b'>"
           "<Kind>can</Kind><Profile>raw</Profile>" +
           rates + "<Provision>" + attribute("Latency", "300") + attribute("Period", "1000") +
           "</Provision><Binding channel='c'" + format +
           "><Identifier form='standard'>0x10</Identifier></Binding></Network>"
           "<Publisher name='p' channel='c' network='b'/>"
           "<Subscriber name='s' channel='c' network='b'/></System>";
  };
  const Folder folder;
  EXPECT_EQ(output_of(kCheck + folder.add("timed.xml", bus("<Bus bitrate='500000'/>", ""))),
            note("p") + ended_with(0));
  for (const std::string format : {"fd", "any", "xl", " any "})
    EXPECT_EQ(output_of(kCheck + folder.add("fd.xml", bus("", " format='" + format + "'"))),
              note("p") + ended_with(0))
        << format;
  EXPECT_EQ(output_of(kCheck + folder.add("classic.xml", bus("", " format='classic'"))),
            ended_with(0));
  EXPECT_EQ(output_of(kCheck + folder.add("virtual.xml", bus("", ""))), ended_with(0));
}

TEST(Twin, WritesXmlOnDemand) {
  const std::string command =
      "xsltproc --nonet --stringparam format xml description/check.xsl "
      "tests/description/twin/cases/CASE.xml | xmllint --xpath \"count(/Findings/Finding[";
  const auto count = [&](const std::string& name, const std::string& condition) {
    auto text = command + condition + "])\" -";
    return output_of(text.replace(text.find("CASE"), 4, name));
  };
  EXPECT_EQ(count("hop-unfit",
                  "@id='MLCCA021' and @channel='c' and @publisher='p' and @subscriber='s' and "
                  "@hop='n' and @attribute='Omission' and @required='2' and @provided='5' and "
                  "@unit='events'"),
            "1\n");
  EXPECT_EQ(count("hop-unfit", "true()"), "1\n");
  EXPECT_EQ(count("not-provided", "@id='MLCCA021' and not(@provided)"), "1\n");
  EXPECT_EQ(count("no-publisher", "@id='MLCCA010' and @subscriber='s' and not(@publisher)"), "1\n");
  EXPECT_EQ(count("hop-equal", "true()"), "0\n");
}

}  // namespace
}  // namespace mlcca::testing
