// SPDX-License-Identifier: BSD-2-Clause
// mlccactl describe: what it creates, what it changes, and what it leaves alone.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "description/read.hpp"
#include "tests/tools/design/describe/program.hpp"
#include "tools/design/safe_file.hpp"

namespace mlcca::test {
namespace {

using Json = nlohmann::json;

/// A file of another author: comments everywhere, several layouts, both kinds of quotes.
constexpr const char* kAnnotated = R"xml(<?xml version='1.0'?>
<!-- Owner: the safety group.
     Do not touch. -->
<?editor indent="yes"?>

<EventChannel  name = 'emergency-switch'
               safe-side="drop">   <!-- two blanks -->
  <SubjectUID> 0xa4efeccc3210b497 </SubjectUID> <!-- from the list -->

	<Description>says &quot;stop&quot; &#x41;</Description>
  <Attributes>
    <!-- agreed on Monday -->
    <Attribute><Name>Omission</Name><Value>2<!-- was 3 --></Value></Attribute> <!-- two -->
    <Attribute>
        <Name>Period</Name>
        <Dimension>
            <SIUnit><Seconds>1</Seconds></SIUnit> <!-- seconds -->
            <Magnitude>-3</Magnitude>
        </Dimension>
        <Value>
            50
        </Value>
    </Attribute>

    <!-- the end -->
  </Attributes>
</EventChannel>
<!-- behind the root -->
)xml";

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> out;
  std::string::size_type at = 0;
  for (auto end = text.find('\n'); end != std::string::npos; end = text.find('\n', at)) {
    out.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  out.push_back(text.substr(at));
  return out;
}

/// Pairs of the lines that differ; the numbers of lines must be equal.
std::vector<std::pair<std::string, std::string>> differences(const std::string& a,
                                                             const std::string& b) {
  const auto left = lines_of(a);
  const auto right = lines_of(b);
  EXPECT_EQ(left.size(), right.size()) << b;
  std::vector<std::pair<std::string, std::string>> out;
  for (std::size_t i = 0; i < std::min(left.size(), right.size()); ++i)
    if (left[i] != right[i]) out.emplace_back(left[i], right[i]);
  return out;
}

using Lines = std::vector<std::pair<std::string, std::string>>;

TEST(DescribeTest, CreatesTheFileOfThePaper) {
  const Folder folder;
  const auto file = folder.path("switch.xml");
  const auto ran = run({"describe", file, "--subject", "0xa4efeccc3210b497", "--description",
                        "emergency switch", "--set", "Omission=2", "--set", "Period=50ms"});
  ASSERT_EQ(ran.status, 0) << ran.error;
  EXPECT_EQ(content_of(file),
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
            "<EventChannel>\n"
            "  <SubjectUID>0xa4efeccc3210b497</SubjectUID>\n"
            "  <Description>emergency switch</Description>\n"
            "  <Attributes omission=\"2\" period=\"50ms\"/>\n"
            "</EventChannel>\n");
  EXPECT_TRUE(description::check_part(file).empty());
}

TEST(DescribeTest, ANewFileHasARandomSubject) {
  const Folder folder;
  std::vector<std::string> subjects;
  for (const char* name : {"a.xml", "b.xml"}) {
    const auto ran = run({"--json", "describe", folder.path(name), "--name", "x"});
    ASSERT_EQ(ran.status, 0) << ran.error;
    subjects.push_back(Json::parse(ran.out).at("subject"));
    EXPECT_TRUE(description::check_part(folder.path(name)).empty());
    EXPECT_EQ(subjects.back().size(), 18U);
    EXPECT_NE(subjects.back(), "0x0000000000000000");
  }
  EXPECT_NE(subjects[0], subjects[1]);
}

TEST(DescribeTest, AnEditTouchesOnlyTheLineOfWhatIsChanged) {
  struct Case {
    std::vector<std::string> flags;
    Lines lines;
  };
  const std::vector<Case> cases = {
      {{"--set", "Omission=4"},
       {{"    <Attribute><Name>Omission</Name><Value>2<!-- was 3 --></Value></Attribute> <!-- two "
         "-->",
         "    <Attribute><Name>Omission</Name><Value>4<!-- was 3 --></Value></Attribute> <!-- two "
         "-->"}}},
      {{"--set", "Period=40ms"}, {{"            50", "            40"}}},
      {{"--set", "Period=50us"},
       {{"            <Magnitude>-3</Magnitude>", "            <Magnitude>-6</Magnitude>"}}},
      {{"--subject", "0x12"},
       {{"  <SubjectUID> 0xa4efeccc3210b497 </SubjectUID> <!-- from the list -->",
         "  <SubjectUID> 0x12 </SubjectUID> <!-- from the list -->"}}},
      {{"--name", "stop"},
       {{"<EventChannel  name = 'emergency-switch'", "<EventChannel  name = 'stop'"}}},
      {{"--description", "a < b"},
       {{"\t<Description>says &quot;stop&quot; &#x41;</Description>",
         "\t<Description>a &lt; b</Description>"}}},
      {{"--safe-side", "deliver"},
       {{"               safe-side=\"drop\">   <!-- two blanks -->",
         "               safe-side=\"deliver\">   <!-- two blanks -->"}}},
  };
  for (const auto& [flags, lines] : cases) {
    const Folder folder;
    const auto file = folder.write("c.xml", kAnnotated);
    auto arguments = std::vector<std::string>{"describe", file};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const auto ran = run(arguments);
    ASSERT_EQ(ran.status, 0) << ran.error;
    EXPECT_EQ(differences(kAnnotated, content_of(file)), lines) << flags[1];
    EXPECT_TRUE(description::check_part(file).empty());
  }
}

TEST(DescribeTest, WhatIsSoAlreadyIsNotWritten) {
  const Folder folder;
  const auto file = folder.write("c.xml", kAnnotated);
  struct stat before{};
  ASSERT_EQ(::stat(file.c_str(), &before), 0);
  const auto ran = run({"describe", file, "--set", "Period=0.05s", "--set", "Omission=2", "--name",
                        "emergency-switch", "--description", "says \"stop\" A"});
  EXPECT_EQ(ran.status, 0) << ran.error;
  EXPECT_TRUE(ran.out.contains("nothing to change")) << ran.out;
  struct stat after{};
  ASSERT_EQ(::stat(file.c_str(), &after), 0);
  EXPECT_EQ(after.st_ino, before.st_ino);
  EXPECT_EQ(content_of(file), kAnnotated);
}

TEST(DescribeTest, AddsBehindTheLastOneAndItsComment) {
  const Folder folder;
  const auto file = folder.write(
      "c.xml",
      "<EventChannel>\r\n\t<SubjectUID>0x1</SubjectUID>\r\n\t<Attributes>\r\n"
      "\t\t<Attribute><Name>Omission</Name><Value>2</Value></Attribute> <!-- two -->\r\n"
      "\t</Attributes>\r\n</EventChannel>\r\n");
  ASSERT_EQ(run({"describe", file, "--set", "MaxPayload=8"}).status, 0);
  EXPECT_EQ(content_of(file),
            "<EventChannel>\r\n\t<SubjectUID>0x1</SubjectUID>\r\n\t<Attributes>\r\n"
            "\t\t<Attribute><Name>Omission</Name><Value>2</Value></Attribute> <!-- two -->\r\n"
            "\t\t<Attribute>\r\n\t\t\t<Name>MaxPayload</Name>\r\n"
            "\t\t\t<Dimension><SIUnit><Bytes>1</Bytes></SIUnit></Dimension>\r\n"
            "\t\t\t<Value>8</Value>\r\n\t\t</Attribute>\r\n"
            "\t</Attributes>\r\n</EventChannel>\r\n");
  ASSERT_EQ(run({"describe", file, "--unset", "MaxPayload", "--unset", "Omission"}).status, 0);
  EXPECT_EQ(content_of(file),
            "<EventChannel>\r\n\t<SubjectUID>0x1</SubjectUID>\r\n\t<Attributes>\r\n"
            "\t\t <!-- two -->\r\n\t</Attributes>\r\n</EventChannel>\r\n");
}

TEST(DescribeTest, AFileOnOneLineStaysOnOneLine) {
  const Folder folder;
  const auto file = folder.write(
      "c.xml", "<EventChannel><SubjectUID>0x1</SubjectUID><Attributes/></EventChannel>");
  ASSERT_EQ(run({"describe", file, "--set", "Omission=2", "--description", "d"}).status, 0);
  EXPECT_EQ(content_of(file),
            "<EventChannel><SubjectUID>0x1</SubjectUID><Description>d</Description>"
            "<Attributes omission=\"2\"/></EventChannel>");
  ASSERT_EQ(run({"describe", file, "--set-user", "Heat=3"}).status, 0);
  EXPECT_EQ(content_of(file),
            "<EventChannel><SubjectUID>0x1</SubjectUID><Description>d</Description>"
            "<Attributes omission=\"2\"><Attribute><Name>Heat</Name><Value>3</Value></Attribute>"
            "</Attributes></EventChannel>");
}

TEST(DescribeTest, UserDefinedAttributesHaveUnits) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"Temperature=21.5 K", "<Dimension><SIUnit><Kelvins>1</Kelvins></SIUnit></Dimension>"},
      {"Brake=9.81m/s^2",
       "<Dimension><SIUnit><Seconds>-2</Seconds><Metres>1</Metres></SIUnit></Dimension>"},
      {"Way=3mm",
       "<Dimension><SIUnit><Metres>1</Metres></SIUnit><Magnitude>-3</Magnitude></Dimension>"},
      {"Mass=2 g",
       "<Dimension><SIUnit><Kilograms>1</Kilograms></SIUnit><Magnitude>-3</Magnitude></Dimension>"},
      {"Area=2 mm^2",
       "<Dimension><SIUnit><Metres>2</Metres></SIUnit><Magnitude>-6</Magnitude></Dimension>"},
      {"Level=3", "<Name>Level</Name><Value>3</Value>"},
  };
  for (const auto& [typed, expected] : cases) {
    const Folder folder;
    const auto file = folder.path("c.xml");
    const auto ran = run({"describe", file, "--set-user", typed});
    ASSERT_EQ(ran.status, 0) << ran.error;
    EXPECT_TRUE(content_of(file).contains(expected)) << typed << content_of(file);
    EXPECT_TRUE(description::check_part(file).empty());
  }
}

/// Two channels, and an attribute that is declared in kelvins.
constexpr const char* kSystem = R"xml(<System name="s">
  <UserAttribute name="Temperature">
    <Dimension><SIUnit><Kelvins>1</Kelvins></SIUnit></Dimension>
    <Better>smaller</Better><Composition>maximum</Composition>
  </UserAttribute>
  <EventChannel name="first"><SubjectUID>0x1</SubjectUID></EventChannel>
  <EventChannel name="second">
    <SubjectUID>0x2</SubjectUID>
  </EventChannel>
</System>
)xml";

TEST(DescribeTest, EditsAChannelInsideOfASystem) {
  const Folder folder;
  const auto file = folder.write("s.xml", kSystem);
  const auto unclear = run({"describe", file, "--set", "Omission=1"});
  EXPECT_EQ(unclear.status, 2);
  EXPECT_TRUE(unclear.error.contains("--channel says which: first, second")) << unclear.error;
  ASSERT_EQ(run({"describe", file, "--channel", "0x2", "--set", "Temperature=300K"}).status, 0);
  auto expected = std::string(kSystem);
  expected.insert(expected.find("  </EventChannel>\n</System>"),
                  "    <Attributes>\n      <Attribute>\n        <Name>Temperature</Name>\n"
                  "        <Dimension><SIUnit><Kelvins>1</Kelvins></SIUnit></Dimension>\n"
                  "        <Value>300</Value>\n      </Attribute>\n    </Attributes>\n");
  EXPECT_EQ(content_of(file), expected);
  EXPECT_TRUE(description::read(file).has_value());
}

TEST(DescribeTest, WhatItDoesNotEditIsLeftAsItIs) {
  const Folder folder;
  // The number of a medium is no reference to the channel of that subject.
  const std::string text =
      "<System name=\"s\">\n"
      "  <EventChannel name=\"c\" importance = '200' safe-side=\"drop\">\n"
      "    <SubjectUID>0x10</SubjectUID>\n"
      "    <Attributes><Attribute><Name>Omission</Name><Value>2</Value></Attribute></Attributes>\n"
      "  </EventChannel>\n"
      "  <Network name=\"bus\">\n"
      "    <Kind>can</Kind><Profile>raw</Profile><Bus bitrate=\"500000\" "
      "background-load=\"0.05\"/>\n"
      "  </Network>\n"
      "  <Network name=\"net\"><Kind>mesh</Kind><Mesh limit=\"0.80\"><!-- measured -->\n"
      "    <PerHop><Attribute><Name>Omission</Name><Value>0</Value></Attribute></PerHop>\n"
      "    <Node name=\"a\" address=\"02:00:00:00:00:0A\"/><Node name=\"b\" "
      "address=\"10.0.0.1\"/>\n"
      "    <Link from=\"a\" to=\"b\" rate=\"24000000\" channel=\"10\"/>\n"
      "  </Mesh></Network>\n"
      "</System>\n";
  const auto file = folder.write("s.xml", text);
  const auto ran =
      run({"describe", file, "--set", "Omission=3", "--subject", "0x11", "--name", "d"});
  ASSERT_EQ(ran.status, 0) << ran.error;
  EXPECT_EQ(differences(text, content_of(file)),
            (Lines{{"  <EventChannel name=\"c\" importance = '200' safe-side=\"drop\">",
                    "  <EventChannel name=\"d\" importance = '200' safe-side=\"drop\">"},
                   {"    <SubjectUID>0x10</SubjectUID>", "    <SubjectUID>0x11</SubjectUID>"},
                   {"    <Attributes><Attribute><Name>Omission</Name><Value>2</Value></Attribute>"
                    "</Attributes>",
                    "    <Attributes><Attribute><Name>Omission</Name><Value>3</Value></Attribute>"
                    "</Attributes>"}}));
  EXPECT_TRUE(description::read(file).has_value());
}

TEST(DescribeTest, ANameThatOthersReferToStays) {
  const Folder folder;
  auto text = std::string(kSystem);
  text.insert(text.find("</System>"),
              "  <Subscriber channel=\"second\" network=\"n\"/>\n"
              "  <Subscriber channel='first' network=\"n\"/>\n"
              "  <Publisher channel=\"first\" network=\"n\"/>\n"
              "  <Publisher channel=\"0x01\" network=\"n\"/>\n"
              "  <Network name=\"n\"><Kind>other</Kind></Network>\n");
  const auto file = folder.write("s.xml", text);
  for (const char* name : {"third", ""}) {
    const auto ran = run({"describe", file, "--channel", "first", "--name", name});
    EXPECT_EQ(ran.status, 2);
    EXPECT_TRUE(ran.error.contains("line 11: Subscriber refers to the channel as first"))
        << ran.error;
    EXPECT_EQ(content_of(file), text);
  }
  const auto moved = run({"describe", file, "--channel", "first", "--subject", "0x3"});
  EXPECT_EQ(moved.status, 2);
  EXPECT_TRUE(moved.error.contains("line 13: Publisher refers to the channel as 0x01"))
      << moved.error;
  EXPECT_EQ(content_of(file), text);
  EXPECT_EQ(run({"describe", file, "--channel", "second", "--subject", "0x3"}).status, 0);
}

TEST(DescribeTest, WhatIsWrongIsRefusedAndNothingIsWritten) {
  struct Case {
    std::vector<std::string> flags;
    const char* text;
  };
  const std::vector<Case> cases = {
      {{"--set", "Period=50"}, "needs a unit: ns, us, ms, s, min or h"},
      {{"--set", "Period=0ms"}, "must be more than 0 ns"},
      {{"--set", "period=5ms"}, "it is spelled Period"},
      {{"--set", "Perod=5ms"}, "an attribute of your own is set by --set-user"},
      {{"--set-user", "Period=5 s"}, "is built in"},
      {{"--set-user", "Way=3 parsec"}, "is not a unit"},
      {{"--set", "Temperature=3 m"}, "the file declares it in another unit: such as 1 K"},
      {{"--set", "PacketLoss=101%"}, "at most 100%"},
      {{"--unset", "Jitter"}, "there is no such attribute set"},
      {{"--subject", "0"}, "0x"},
      {{"--subject", "0x0"}, "0 means no subject"},
      {{"--subject", "0x2"}, "subjects are unique"},
      {{"--name", "second"}, "names are unique"},
      {{"--name", "a b"}, "--name: "},
      {{"--safe-side", "left"}, "drop"},
      {{"--description", "a\tb"}, "control characters"},
      {{"--description", "\xff"}, "not UTF-8"},
      {{"--description", std::string(1025, 'x')}, "--description: "},
      {{"--priority", "1001", "--set", "Omission=1"}, "-1000 to 1000"},
      {{"--remove-set", "3"}, "there is no such attribute set"},
      {{"--channel", "third", "--set", "Omission=1"}, "there is no channel third"},
  };
  for (const auto& [flags, text] : cases) {
    const Folder folder;
    const auto file = folder.write("s.xml", kSystem);
    auto arguments = std::vector<std::string>{"describe", file};
    if (flags[0] != "--channel") arguments.insert(arguments.end(), {"--channel", "first"});
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const auto ran = run(arguments);
    EXPECT_EQ(ran.status, 2) << flags[0] << flags[1];
    EXPECT_TRUE(ran.error.contains(text)) << flags[0] << flags[1] << ran.error;
    EXPECT_EQ(content_of(file), kSystem) << flags[1];
  }
}

TEST(DescribeTest, OneWrongFlagUndoesTheOthers) {
  const Folder folder;
  const auto file = folder.write("c.xml", kAnnotated);
  EXPECT_EQ(run({"describe", file, "--set", "Omission=7", "--set", "Period=x"}).status, 2);
  EXPECT_EQ(content_of(file), kAnnotated);
}

TEST(DescribeTest, FilesThatCannotBeEditedAreLeftAlone) {
  const std::string channel = "<EventChannel><SubjectUID>0x1</SubjectUID></EventChannel>";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"<!DOCTYPE EventChannel [<!ENTITY a \"b\">]>" + channel, "DOCTYPE"},
      {"<?xml version='1.0' encoding='ISO-8859-1'?>" + channel, "encoding ISO-8859-1"},
      {"<EventChannel><SubjectUID>0x1</SubjectUID><Description>\xe4</Description></EventChannel>",
       "line 1"},
      {std::string("\xff\xfe<\0", 4), "UTF-16"},
      {"", "the file is empty"},
      {"<EventChannel>", "line 1"},
      {"<EventChannel>\n<Subject>0x1</Subject></EventChannel>", "line 2: Element 'Subject'"},
      {"<System name=\"s\"/>", "there is no EventChannel"},
  };
  for (const auto& [text, expected] : cases) {
    const Folder folder;
    const auto file = folder.write("c.xml", text);
    const auto ran = run({"describe", file, "--name", "x"});
    EXPECT_EQ(ran.status, 2) << text;
    EXPECT_TRUE(ran.error.contains(expected)) << ran.error;
    EXPECT_EQ(content_of(file), text);
  }
}

TEST(DescribeTest, ATooLargeFileIsNotRead) {
  const Folder folder;
  const auto file = folder.write("c.xml", "<EventChannel/>");
  ASSERT_EQ(::truncate(file.c_str(), (16 << 20) + 1), 0);
  const auto ran = run({"describe", file, "--name", "x"});
  EXPECT_EQ(ran.status, 2);
  EXPECT_TRUE(ran.error.contains("larger than 16777216 bytes")) << ran.error;
}

TEST(DescribeTest, KeepsModeAndOwnerAndFollowsALink) {
  const Folder folder;
  const auto file = folder.write("c.xml", kAnnotated);
  const auto link = folder.path("link.xml");
  ASSERT_EQ(::symlink("c.xml", link.c_str()), 0);
  ASSERT_EQ(::chmod(file.c_str(), 0640), 0);
  const bool root = ::geteuid() == 0;
  if (root) {
    ASSERT_EQ(::chown(file.c_str(), 12345, 23456), 0);
  }
  ASSERT_EQ(run({"describe", link, "--set", "Omission=7"}).status, 0);
  struct stat now{};
  ASSERT_EQ(::lstat(link.c_str(), &now), 0);
  EXPECT_TRUE(S_ISLNK(now.st_mode));
  ASSERT_EQ(::stat(file.c_str(), &now), 0);
  EXPECT_EQ(now.st_mode & 07777U, 0640U);
  if (root) {
    EXPECT_EQ(now.st_uid, 12345U);
    EXPECT_EQ(now.st_gid, 23456U);
  }
  EXPECT_TRUE(content_of(file).contains("<Value>7<!-- was 3 --></Value>"));
}

TEST(DescribeTest, WhatAnotherProgramWroteMeanwhileIsNotLost) {
  const Folder folder;
  const auto file = folder.write("c.xml", "one");
  const auto read = tools::design::read_file(file, 100);
  ASSERT_TRUE(read.has_value() && read->has_value());
  folder.write("c.xml", "another one's");
  EXPECT_FALSE(tools::design::replace_file(**read, "two").has_value());
  EXPECT_EQ(content_of(file), "another one's");
  EXPECT_FALSE(tools::design::create_file(file, "three").has_value());
  EXPECT_EQ(content_of(file), "another one's");
}

TEST(DescribeTest, ADryRunPrintsTheResultAndWritesNothing) {
  const Folder folder;
  const auto file = folder.write("c.xml", kAnnotated);
  const auto ran = run({"describe", file, "--set", "Omission=4", "--dry-run"});
  EXPECT_EQ(ran.status, 0);
  EXPECT_EQ(differences(kAnnotated, ran.out).size(), 1U);
  EXPECT_EQ(content_of(file), kAnnotated);
}

TEST(DescribeTest, JsonSaysWhatWasDone) {
  const Folder folder;
  const auto file = folder.write("c.xml", kAnnotated);
  const auto ran = run({"--json", "describe", file, "--set", "Omission=4"});
  const auto json = Json::parse(ran.out);
  EXPECT_EQ(json.at("written"), true);
  EXPECT_EQ(json.at("created"), false);
  EXPECT_EQ(json.at("subject"), "0xa4efeccc3210b497");
  EXPECT_EQ(json.at("changes"), Json::parse(R"([{"what":"Omission","before":"2","after":"4"}])"));
  const auto refused = run({"--json", "describe", file, "--set", "Omission=x"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_EQ(Json::parse(refused.out).at("error").at("kind"), "invalid");
}

TEST(DescribeTest, WithoutATerminalAndWithoutFlagsNothingIsDone) {
  const Folder folder;
  const auto ran = run({"describe", folder.path("c.xml")});
  EXPECT_EQ(ran.status, 2);
  EXPECT_TRUE(ran.error.contains("nothing to change")) << ran.error;
  EXPECT_NE(::access(folder.path("c.xml").c_str(), F_OK), 0);
}

}  // namespace
}  // namespace mlcca::test
