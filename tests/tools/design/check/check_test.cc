// SPDX-License-Identifier: BSD-2-Clause
// mlccactl check as a user and a script see it: exit status, text, JSON, --output.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/tools/design/check/program.hpp"

namespace mlcca {
namespace {

using Json = nlohmann::json;
using test::delivery;
using test::system_of;

class ExitTest : public test::CheckTest {
 protected:
  static int status_of(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "check");
    return test::run(arguments).status;
  }
  std::string good() { return file("good.xml", system_of(delivery(2, 2))); }
  std::string bad() { return file("bad.xml", system_of(delivery(2, 3))); }
  std::string broken() { return file("broken.xml", "<System"); }
  std::string noted() {
    return file("noted.xml",
                system_of("<EventChannel name=\"a\"><SubjectUID>0x1</SubjectUID></EventChannel>"));
  }
  std::string part(const std::string& name, const std::string& network) {
    return file(name, "<Network name=\"" + network + "\"><Kind>mesh</Kind></Network>");
  }
};

/// A mesh of one link of 11 Mbit/s that also states a bandwidth, and a stream that is too fast for
/// both: the smaller one is said, and no other.
/// From a node to itself nothing is sent, whatever is known of links.
TEST_F(ExitTest, NoLinkIsMissingWhereAllEventsStayAtOneNode) {
  const auto of = [&](const std::string& node) {
    return file(node + ".xml",
                system_of("<EventChannel name='v'><SubjectUID>0x1</SubjectUID><Attributes "
                          "period='10ms' maxPayload='8'/></EventChannel><Network name='air'>"
                          "<Kind>mesh</Kind><Mesh><Node name='x' address='02:00:00:00:00:01'/>"
                          "<Node name='y' address='02:00:00:00:00:02'/></Mesh></Network>"
                          "<Publisher name='p' channel='v' network='air' mesh-node='x'/>"
                          "<Subscriber name='s' channel='v' network='air' mesh-node='" +
                          node + "'/>"));
  };
  const auto same = test::run({"check", of("x")});
  EXPECT_EQ(same.status, 0) << same.out;
  EXPECT_FALSE(same.out.contains("MLCCA042")) << same.out;
  EXPECT_TRUE(same.out.contains("1 channel: 1 fit")) << same.out;
  const auto other = test::run({"check", of("y")});
  EXPECT_EQ(other.status, 1) << other.out;
  EXPECT_TRUE(other.out.contains("MLCCA042")) << other.out;
  EXPECT_TRUE(other.out.contains("1 do not fit")) << other.out;
}

TEST_F(ExitTest, AStreamThatIsTooFastForAMeshIsToldOneNumber) {
  const auto bytes_a_second = [](const std::string& value) {
    return "<Attribute><Name>Bandwidth</Name><Dimension><SIUnit><Bytes>1</Bytes><Seconds>-1</"
           "Seconds>"
           "</SIUnit></Dimension><Value>" +
           value + "</Value></Attribute>";
  };
  for (const auto& [stated, id] :
       {std::pair("697674", "MLCCA024"), std::pair("9000000", "MLCCA032")}) {
    const auto path =
        file("fast.xml",
             system_of("<EventChannel name='v'><SubjectUID>0x1</SubjectUID><Attributes>" +
                       bytes_a_second("9500000") +
                       "</Attributes></EventChannel><Network name='air'><Kind>mesh</Kind><Mesh>"
                       "<Node name='x' address='02:00:00:00:00:01'/>"
                       "<Node name='y' address='02:00:00:00:00:02'/>"
                       "<Link from='x' to='y' rate='11000000'/><Source kind='description'/></Mesh>"
                       "<Provision>" +
                       bytes_a_second(stated) +
                       "</Provision></Network><Publisher name='p' channel='v' network='air'/>"
                       "<Subscriber name='s' channel='v' network='air'/>"));
    const auto found = Json::parse(test::run({"check", "--json", path}).out).at("findings");
    std::vector<std::string> errors;
    for (const auto& finding : found)
      if (finding.at("severity") == "error") errors.push_back(finding.at("id"));
    EXPECT_EQ(errors, std::vector<std::string>{id}) << found;
  }
}

TEST_F(ExitTest, Is0WhereNothingIsFoundButNotes) {
  EXPECT_EQ(status_of({good()}), 0);
  EXPECT_EQ(status_of({noted()}), 0);
}

TEST_F(ExitTest, Is1ForFindings) { EXPECT_EQ(status_of({bad()}), 1); }

TEST_F(ExitTest, IsTheWorstOfSeveralSystems) {
  EXPECT_EQ(status_of({good(), bad()}), 1);
  EXPECT_EQ(status_of({bad(), good()}), 1);
  EXPECT_EQ(status_of({bad(), broken(), good()}), 2);
}

TEST_F(ExitTest, Is2ForWhatCannotBeRead) {
  std::filesystem::create_directory(path("folder"));
  ASSERT_EQ(::mkfifo(path("fifo").c_str(), 0600), 0);
  EXPECT_EQ(status_of({broken()}), 2);
  EXPECT_EQ(status_of({path("none.xml")}), 2);
  EXPECT_EQ(status_of({path("folder")}), 2);
  EXPECT_EQ(status_of({path("fifo")}), 2) << "without a writer";
  EXPECT_EQ(status_of({file("empty.xml", "")}), 2);
}

TEST_F(ExitTest, Is2WhereReadingIsForbidden) {
  const auto name = good();
  ASSERT_EQ(::chmod(name.c_str(), 0), 0);
  test::Surroundings how;
  how.without_privileges = true;
  const auto outcome = test::run({"check", name}, how);
  EXPECT_EQ(outcome.status, 2);
  EXPECT_TRUE(outcome.out.contains("MLCCA001: cannot open the file: Permission denied"))
      << outcome.out;
}

TEST_F(ExitTest, Is2ForAWrongCommandLine) {
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{},
                                                    {"--format", "pdf", good()},
                                                    {"--unknown", good()},
                                                    {"--output"}}) {
    auto all = arguments;
    all.insert(all.begin(), "check");
    const auto outcome = test::run(all);
    EXPECT_EQ(outcome.status, 2) << outcome.error;
    EXPECT_TRUE(outcome.error.starts_with("mlccactl: ")) << outcome.error;
    EXPECT_EQ(outcome.out, "");
  }
}

TEST_F(ExitTest, Is3WhereNothingCanBeWritten) {
  test::Surroundings how;
  how.out = "/dev/full";
  const auto outcome = test::run({"check", good()}, how);
  EXPECT_EQ(outcome.status, 3);
  EXPECT_EQ(outcome.error, "mlccactl: standard output: No space left on device\n");
  EXPECT_EQ(status_of({"--output", "/dev/full", good()}), 3);
  EXPECT_EQ(status_of({"--output", path("no/such/folder/report"), good()}), 3);
  EXPECT_EQ(status_of({"--output", folder(), good()}), 3);
}

TEST_F(ExitTest, AFileThatIsGivenTwiceIsCheckedOnce) {
  const auto outcome = test::run({"check", "--json", bad(), bad()});
  EXPECT_EQ(outcome.status, 1);
  const auto json = Json::parse(outcome.out);
  EXPECT_EQ(json["systems"].size(), 1U);
  EXPECT_EQ(json["errors"], 1);
}

TEST_F(ExitTest, PartsAreCheckedAloneOrWithASystem) {
  const auto air = part("air.xml", "air");
  const auto alone = test::run({"check", air, part("wrong.xml", "1")});
  EXPECT_EQ(alone.status, 2) << "does not fit the schema";
  EXPECT_TRUE(alone.out.contains("wrong.xml:1: error MLCCA003: <Network>: ")) << alone.out;
  const auto fine = test::run({"check", air});
  EXPECT_EQ(fine.status, 0);
  EXPECT_EQ(fine.out, "no problems: each part fits the schema\n");
  const auto user = file("user.xml", system_of("<Component name=\"c\" network=\"air\"/>"));
  EXPECT_EQ(status_of({user}), 1) << "the network is not known";
  EXPECT_EQ(status_of({user, air}), 0);
  EXPECT_EQ(status_of({air, user}), 0) << "in any order";
}

class TextTest : public ExitTest {};

TEST_F(TextTest, SaysEachFindingOnALineThatAnEditorFollows) {
  const auto name = bad();
  const auto outcome = test::run({"check", name});
  EXPECT_EQ(outcome.out,
            name +
                ":5: error MLCCA021: speed@air to speed@air: Omission 2 required by speed@air, "
                "air provides 3 (1 too many)\n"
                "    hint: let air provide Omission 2 or better, ask less, or take another route\n"
                "test: 1 channel: 0 fit, 0 decided at run time, 1 do not fit\n"
                "1 error, 0 warnings, 0 notes\n");
}

TEST_F(TextTest, SaysHowLongAnEventMayBeOnANetworkOfDatagrams) {
  const auto said = [](const std::string& name) {
    return test::run({"check", "tests/tools/design/check/cases/" + name}).out;
  };
  EXPECT_TRUE(
      said("too-long-for-radio.xml")
          .contains("an event of 103 bytes does not fit a frame of radio: at most 102 bytes"));
  const auto datagrams = said("too-long-for-datagrams.xml");
  EXPECT_TRUE(datagrams.contains(" does not fit the fragments of radio: at most 65535 bytes"))
      << datagrams;
  EXPECT_TRUE(datagrams.contains("no network carries longer events"));
}

/// The rule's error and what does not fit are the same thing: nothing is promised without it.
TEST_F(TextTest, OfASystemThatIsNotUsableItSaysWhatTheDeliveriesByThemselvesGive) {
  const auto name = file(
      "long.xml",
      system_of("<EventChannel name='c'><SubjectUID>0x1</SubjectUID>"
                "<Attributes period='50ms' maxPayload='12'/></EventChannel>"
                "<Network name='a'><Kind>can</Kind><Profile>raw</Profile><Bus bitrate='500000'/>"
                "<Binding channel='c'><Identifier form='standard'>0x10</Identifier></Binding>"
                "</Network><Publisher name='p' channel='c' network='a'/>"
                "<Subscriber name='s' channel='c' network='a'/>"));
  const auto outcome = test::run({"check", name});
  EXPECT_TRUE(outcome.out.contains("error MLCCA025")) << outcome.out;
  EXPECT_TRUE(outcome.out.contains(
      "test: not usable for these errors; its deliveries by themselves: 1 channel: 0 would fit, 0 "
      "decided at run time, 1 do not fit\n1 error, 0 warnings, 0 notes\n"))
      << outcome.out;
}

TEST_F(TextTest, HasColoursOnATerminalOnly) {
  const auto name = bad();
  test::Running terminal({"check", name}, test::Running::Where::terminal);
  const auto coloured = terminal.await_end();
  EXPECT_TRUE(
      coloured.starts_with("\x1b[1m" + name + ":5\x1b[0m: \x1b[1;31merror MLCCA021:\x1b[0m"))
      << coloured;
  EXPECT_EQ(terminal.wait(), 1);
  test::Running plain({"check", "--no-color", name}, test::Running::Where::terminal);
  EXPECT_FALSE(plain.await_end().contains('\x1b'));
  EXPECT_FALSE(test::run({"check", name}).out.contains('\x1b'));
}

TEST_F(TextTest, NoNameReachesTheTerminalWithControlCharacters) {
  const std::string hostile =
      "a\x1b]0;title\x07\xc2\x9b"
      "31m\nb.xml";
  std::string all;
  for (const auto& content : {system_of(delivery(2, 3)), std::string("<System"),
                              system_of("<xi:include href=\"%1b%5b2J.xml\"/>")}) {
    const auto outcome = test::run({"check", file(hostile, content)});
    all += outcome.out + outcome.error;
  }
  all += test::run({"check", "--output", path(hostile), path(hostile)}).error;
  EXPECT_TRUE(all.contains("a?]0;title?")) << all;
  EXPECT_EQ(std::ranges::count_if(
                all, [](char c) { return static_cast<unsigned char>(c) < 0x20 && c != '\n'; }),
            0)
      << all;
  EXPECT_FALSE(all.contains("\xc2\x9b")) << all;
}

TEST_F(TextTest, SaysWhenDeliveriesAreNotChecked) {
  const auto unknown =
      test::run({"check", file("u.xml", system_of("<Component name=\"c\" network=\"sea\"/>"))});
  EXPECT_EQ(unknown.status, 1);
  EXPECT_TRUE(
      unknown.out.contains("test: deliveries are checked when the names and rules are right\n"))
      << unknown.out;
  const auto broken_one = test::run({"check", broken()});
  EXPECT_TRUE(broken_one.out.contains("broken.xml: cannot be read\n")) << broken_one.out;
}

class JsonTest : public ExitTest {};

TEST_F(JsonTest, IsOneObjectOnOneLineWithTheFieldsThatApply) {
  const auto name = bad();
  const auto outcome = test::run({"check", "--json", name});
  EXPECT_EQ(outcome.out.find('\n'), outcome.out.size() - 1);
  const auto json = Json::parse(outcome.out);
  EXPECT_EQ(json["version"], 1);
  EXPECT_EQ(
      json["systems"],
      Json::array({{{"file", name},
                    {"name", "test"},
                    {"readable", true},
                    {"usable", true},
                    {"inspected", true},
                    {"channels",
                     {{"all", 1}, {"fit", 0}, {"run_time", 0}, {"unfit", 1}, {"unused", 0}}}}}));
  ASSERT_EQ(json["findings"].size(), 1U);
  const auto& f = json["findings"][0];
  EXPECT_EQ(f["id"], "MLCCA021");
  EXPECT_EQ(f["severity"], "error");
  EXPECT_EQ(f["name"], "hop-unfit");
  EXPECT_EQ(f["line"], 5);
  EXPECT_EQ(f["channel"], "speed");
  EXPECT_EQ(f["place"], "air");
  EXPECT_EQ(f["attribute"], "Omission");
  EXPECT_EQ(f["required"], "2");
  EXPECT_EQ(f["provided"], "3");
  EXPECT_FALSE(f.contains("element"));
  EXPECT_EQ(json["errors"], 1);
  EXPECT_EQ(json["warnings"], 0);
  EXPECT_EQ(test::run({"check", "--format", "json", name}).out, outcome.out);
  EXPECT_EQ(test::run({"--json", "check", name}).out, outcome.out);
}

TEST_F(JsonTest, IsValidForAnyFileName) {
  for (const std::string name : {"quote\".xml", "back\\slash.xml", "line\nend.xml", "\xff\xfe.xml",
                                 "tab\t\x01.xml", "ä€😀.xml"}) {
    const auto outcome = test::run({"check", "--json", file(name, "<Nothing/>")});
    EXPECT_EQ(outcome.status, 2);
    const auto json = Json::parse(outcome.out, nullptr, false);
    ASSERT_TRUE(json.is_object()) << outcome.out;
    EXPECT_EQ(json["findings"].size(), 1U);
    const bool utf8 = !name.starts_with('\xff');
    EXPECT_TRUE(!utf8 || json["findings"][0]["file"] == path(name)) << outcome.out;
    const auto sarif = test::run({"check", "--format", "sarif", path(name)});
    EXPECT_TRUE(Json::parse(sarif.out, nullptr, false).is_object()) << sarif.out;
  }
}

class OutputTest : public ExitTest {};

TEST_F(OutputTest, IsWrittenInsteadOfStandardOutput) {
  const auto report = path("report.json");
  const auto outcome = test::run({"check", "--json", "--output", report, bad()});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(Json::parse(test::content_of(report))["errors"], 1);
  EXPECT_EQ(status_of({"--output", report, "--force", good()}), 0);
  EXPECT_TRUE(test::content_of(report).starts_with("test: 1 channel: 1 fit"));
}

TEST_F(OutputTest, ReplacesAFileAndKeepsItsModeAndLink) {
  const auto report = file("report", "old");
  ASSERT_EQ(::chmod(report.c_str(), 0640), 0);
  std::filesystem::create_symlink("report", path("link"));
  std::filesystem::create_hard_link(report, path("before"));
  EXPECT_EQ(status_of({"--output", path("link"), "--force", good()}), 0);
  EXPECT_TRUE(std::filesystem::is_symlink(path("link")));
  EXPECT_TRUE(test::content_of(report).starts_with("test:"));
  EXPECT_EQ(test::content_of(path("before")), "old") << "who has it open sees the old one";
  struct stat status{};
  ASSERT_EQ(::stat(report.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777U, 0640U);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder()), {}), 4)
      << "nothing else is left there";
}

TEST_F(OutputTest, LeavesTheOldOneWhereTheNewOneCannotBeWritten) {
  std::filesystem::create_directory(path("locked"));
  const auto report = file("locked/report", "old");
  ASSERT_EQ(::chmod(path("locked").c_str(), 0500), 0);
  test::Surroundings how;
  how.without_privileges = true;
  const auto outcome = test::run({"check", "--output", report, "--force", good()}, how);
  EXPECT_EQ(outcome.status, 3);
  EXPECT_EQ(test::content_of(report), "old");
  EXPECT_EQ(::chmod(path("locked").c_str(), 0700), 0);
}

TEST_F(OutputTest, NeverReplacesWhatIsChecked) {
  const auto system = file("s.xml", system_of("<xi:include href=\"part.xml\"/>"));
  const auto included = part("part.xml", "air");
  std::filesystem::create_hard_link(included, path("other-name.xml"));
  for (const auto& name : {system, included, path("other-name.xml")}) {
    const auto before = test::content_of(name);
    const auto outcome = test::run({"check", "--output", name, system});
    EXPECT_EQ(outcome.status, 2);
    EXPECT_TRUE(outcome.error.contains("is a file that is checked")) << outcome.error;
    EXPECT_EQ(test::content_of(name), before);
  }
}

TEST_F(OutputTest, ReachesADeviceOrPipe) {
  EXPECT_EQ(status_of({"--output", "/dev/null", good()}), 0);
  const auto outcome = test::run({"check", "--output", "/dev/stdout", good()});
  EXPECT_EQ(outcome.status, 0);
}

}  // namespace
}  // namespace mlcca
