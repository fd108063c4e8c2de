// SPDX-License-Identifier: BSD-2-Clause
// Tests of `mlccactl learn` on recordings, as a user runs it.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/tools/design/describe/program.hpp"
#include "tests/tools/learn/pcap_file.hpp"
#include "tests/tools/learn/traffic.hpp"

namespace mlcca::test {
namespace {

/// `count` lines of candump with frames of one identifier, one every 100 ms, with `bytes` bytes
/// each.
std::string frames(const std::string& interface, const std::string& id, unsigned bytes,
                   unsigned count) {
  std::string out;
  for (unsigned i = 0; i < count; ++i) {
    const std::string ms = std::to_string(1000 + i % 10 * 100).substr(1);
    out += "(" + std::to_string(100 + i / 10) + "." + ms + "000) " + interface + " " + id + "#";
    for (unsigned b = 0; b < bytes; ++b) out += "A" + std::to_string(i % 10);
    out += "\n";
  }
  return out;
}

using learn::test::event;
using learn::test::kDistance;
using learn::test::kMs;
using learn::test::station;

/// A capture with 60 events of a subject on an Ethernet, one every 100 ms. The file is named like
/// the interface.
std::string datagrams(std::uint64_t subject, std::uint8_t sender, std::size_t bytes) {
  learn::test::PcapFile file(1);
  for (std::uint64_t i = 0; i < 60; ++i) {
    std::vector<std::uint8_t> data(bytes, static_cast<std::uint8_t>(i));
    const std::uint64_t ns = 100'000 * kMs + i * 100 * kMs;
    file.add(ns, frame_of(event(ns, 0, subject, station(sender), data)));
  }
  return file.bytes();
}

/// The exit status of that command with more arguments, whose error must say that.
int refused(std::vector<std::string> command, const std::vector<std::string>& more,
            const std::string& says) {
  command.insert(command.end(), more.begin(), more.end());
  const Ran ran = run(command);
  EXPECT_TRUE(ran.error.contains(says)) << ran.error << ran.out;
  return ran.status;
}

struct LearnVerb : ::testing::Test {
  /// The path of a description drafted from 60 frames with identifier 0x123.
  std::string drafted() {
    const auto log = folder.write("first.log", frames("can0", "123", 4, 60));
    const auto path = folder.path("system.xml");
    const Ran ran = run({"learn", log, "--output", path});
    EXPECT_EQ(ran.status, 0) << ran.error;
    return path;
  }
  Folder folder;
};

TEST_F(LearnVerb, WritesADraftThatCheckTakesAndOverwritesNothing) {
  const auto path = drafted();
  const auto checked = run({"check", path});
  EXPECT_EQ(checked.status, 0) << checked.out << checked.error;
  const auto before = content_of(path);
  const auto again = run({"learn", folder.path("first.log"), "--output", path});
  EXPECT_EQ(again.status, 3) << "as of import, export and new";
  EXPECT_TRUE(again.error.contains("nothing is overwritten")) << again.error;
  EXPECT_EQ(content_of(path), before);
}

TEST_F(LearnVerb, AnOutputThatCannotBeCreatedIsNoMistakeInTheCommandLine) {
  const auto log = folder.write("first.log", frames("can0", "123", 4, 60));
  const Ran ran = run({"learn", log, "--output", folder.path("none/system.xml")});
  EXPECT_EQ(ran.status, 3);
  EXPECT_TRUE(ran.error.contains("--output " + folder.path("none/system.xml") +
                                 ": there is no folder " + folder.path("none") + ": make it"))
      << ran.error;
  const Ran in_file = run({"learn", log, "--output", log + "/system.xml"});
  EXPECT_EQ(in_file.status, 3);
  EXPECT_TRUE(in_file.error.contains(log + " is no folder")) << in_file.error;
}

TEST_F(LearnVerb, SaysWhatCannotBeUsed) {
  const auto log = folder.write("first.log", frames("can0", "123", 4, 60));
  const std::pair<std::vector<std::string>, const char*> cases[] = {
      {{folder.path("nowhere.log")}, "there is neither such a file nor such an interface"},
      {{log, "--for", "soon"}, "--for 'soon': must be whole numbers"},
      {{log, "--name", "a b"}, "--name: "},
      {{log, "--gateway", "<g>"}, "--gateway: "},
      {{log, "--profile", "can0=none"}, "write an interface and one of raw, famouso"},
      {{log, "--bitrate", "500k"}, "write can0=500k"},
      {{log, "--bitrate", "can9=500k"}, "there is no interface can9: can0"},
      {{log, "--data-bitrate", "can9=2M"}, "there is no interface can9: can0"},
      {{log, "--profile", "can7=j1939"}, "there is no interface can7: can0"},
      {{log, "--merge", folder.write("bad.xml", "<System/>")}, "cannot be used"}};
  for (const auto& [more, says] : cases) EXPECT_EQ(refused({"learn"}, more, says), 2) << says;
}

TEST_F(LearnVerb, SaysWhatCannotBeUsedBeforeItListens) {
  const std::pair<std::vector<std::string>, const char*> cases[] = {
      {{"--user", "a b"}, "--user a b: "},
      {{"--bitrate", "can0=10G"}, "--bitrate can0=10G: '10G': a CAN bus has at most 1 Mbit/s"},
      {{"--data-bitrate", "can0=9M"},
       "--data-bitrate can0=9M: '9M': a CAN bus has at most 8 Mbit/s"},
      {{"--bitrate", "can0=250k", "--bitrate", "can0=500k"},
       "--bitrate can0=500k: the option names can0 twice"},
      {{"--profile", "can0=raw", "--profile", "can0=j1939"},
       "--profile can0=j1939: the option names can0 twice"},
      {{"lo"}, "lo is given twice: each interface counts once"},
      {{}, "lo: is neither a CAN nor an Ethernet interface"}};
  for (const auto& [more, says] : cases)
    EXPECT_EQ(refused({"learn", "lo", "--for", "1s"}, more, says), 2) << says;
}

TEST_F(LearnVerb, AnOptionWithoutEffectIsRefused) {
  const auto log = folder.write("first.log", frames("can0", "123", 4, 60));
  const auto trace = folder.write("eth0.pcap", datagrams(kDistance, 7, 8));
  const std::pair<std::vector<std::string>, const char*> cases[] = {
      {{log, "--for", "5s"}, "--for 5s: there is no interface to listen to"},
      {{trace, "--bitrate", "eth0=500k"}, "--bitrate eth0=500k: eth0 is no CAN bus"},
      {{trace, "--data-bitrate", "eth0=2M"}, "--data-bitrate eth0=2M: eth0 is no CAN bus"}};
  for (const auto& [more, says] : cases) EXPECT_EQ(refused({"learn"}, more, says), 2) << says;
}

TEST_F(LearnVerb, WhatCameTooSeldomHasNoKind) {
  std::string log = frames("can0", "2F0", 4, 3000);
  for (unsigned i = 0; i < 30; ++i)
    log += "(" + std::to_string(100 + i * 10) + ".050000) can0 123#11\n";
  const Ran ran =
      run({"learn", folder.write("seldom.log", log), "--output", folder.path("seldom.xml")});
  EXPECT_TRUE(ran.out.contains("too few to tell")) << ran.out << ran.error;
  EXPECT_FALSE(ran.out.contains("aperiodic")) << ran.out;
  const Ran json = run({"learn", folder.path("seldom.log"), "--json"});
  EXPECT_TRUE(json.out.contains(R"("kind":"too few to tell")")) << json.out;
  EXPECT_TRUE(json.out.contains(R"("omission":null)")) << "it has none: " << json.out;
  EXPECT_TRUE(json.out.contains(R"("mean_gap_ns":100000000,"shortest_gap_ns":100000000)"))
      << json.out;
}

TEST_F(LearnVerb, ASingleEventHasNoGaps) {
  const std::string log = frames("can0", "2F0", 4, 60) + "(100.250000) can0 123#11\n";
  const Ran json = run({"learn", folder.write("once.log", log), "--json"});
  EXPECT_TRUE(json.out.contains(R"("median_gap_ns":null,"mean_gap_ns":null,)"
                                R"("shortest_gap_ns":null,"longest_gap_ns":null)"))
      << json.out;
  const Ran ran = run({"learn", folder.path("once.log"), "--output", folder.path("once.xml")});
  EXPECT_FALSE(ran.out.contains("0 ns")) << ran.out << ran.error;
}

TEST_F(LearnVerb, OfTheSameTrafficNothingIsToBeMerged) {
  const auto path = drafted();
  const Ran ran = run({"learn", folder.path("first.log"), "--merge", path});
  EXPECT_EQ(ran.status, 0) << ran.out << ran.error;
  EXPECT_EQ(ran.out, "");
}

TEST_F(LearnVerb, WhatIsNewIsAPatchThatMakesADescription) {
  const auto path = drafted();
  const auto log =
      folder.write("second.log", frames("can0", "123", 4, 60) + frames("can0", "18FEF100", 8, 60));
  const Ran ran = run({"learn", log, "--merge", path});
  EXPECT_EQ(ran.status, 1);
  EXPECT_TRUE(ran.out.contains("+    <Binding channel=\"can0-18FEF100\">")) << ran.out;
  const auto patch = folder.write("change.patch", ran.out);
  const Ran patched = run_program({"patch", path, patch});
  ASSERT_EQ(patched.status, 0) << patched.out;
  EXPECT_EQ(run({"check", path}).status, 0);
  EXPECT_EQ(run({"learn", log, "--merge", path}).status, 0) << "it is all described now";
}

/// `text` with `other` in place of `instead_of`.
std::string with(std::string text, const std::string& instead_of, const std::string& other) {
  const auto at = text.find(instead_of);
  EXPECT_NE(at, std::string::npos) << instead_of << " in " << text;
  return at == std::string::npos ? text : text.replace(at, instead_of.size(), other);
}

TEST_F(LearnVerb, WhatIsProposedForAChannelThatIsThereIsADescriptionThatCheckAccepts) {
  const auto log =
      folder.write("two.log", frames("can0", "123", 4, 60) + frames("can0", "2F0", 4, 60));
  const auto path = folder.path("system.xml");
  ASSERT_EQ(run({"learn", log, "--output", path}).status, 0);
  const std::string all = content_of(path);
  const std::string binding =
      "    <Binding channel=\"can0-2F0\"><Identifier form=\"standard\">0x2f0</Identifier>"
      "</Binding>\n";
  const std::string unbound = with(all, binding, "");
  const std::string otherwise = with(all, "0x2f0", "0x2f1");
  const auto publisher = unbound.find("  <Publisher name=\"can0-2F0\"");
  ASSERT_NE(publisher, std::string::npos);
  const std::string without_ends =
      unbound.substr(0, publisher) + unbound.substr(unbound.find("</System>"));
  const auto subject_at = otherwise.find("<SubjectUID>", otherwise.find("name=\"can0-2F0\""));
  const std::pair<std::string, std::vector<std::string>> cases[] = {
      {without_ends,
       {"+" + binding, "+  <Publisher name=\"can0-2F0\" channel=\"can0-2F0\"",
        "+  <Subscriber channel=\"can0-2F0\" gateway=\"gateway\"/>"}},
      {otherwise,
       {"+  <EventChannel name=\"can0-2F0-2\">", "+    <Binding channel=\"can0-2F0-2\">",
        "+  <Publisher name=\"can0-2F0-2\" channel=\"can0-2F0-2\""}},
      // The same name with another subject, and another name with the same subject.
      {std::string(otherwise).replace(subject_at + 12, 4, "0x1f"), {"name=\"can0-2F0-2\""}},
      {with(with(with(otherwise, "<EventChannel name=\"can0-2F0\"", "<EventChannel name=\"other\""),
                 "<Binding channel=\"can0-2F0\"", "<Binding channel=\"other\""),
            "channel=\"can0-2F0\" network", "channel=\"other\" network"),
       {}}};
  int number = 0;
  for (const auto& [text, proposed] : cases) {
    std::string described = text;
    if (proposed.empty())
      described =
          with(described, "<Subscriber channel=\"can0-2F0\"", "<Subscriber channel=\"other\"");
    const auto changed = folder.write("changed" + std::to_string(++number) + ".xml", described);
    const Ran ran = run({"learn", log, "--merge", changed});
    EXPECT_EQ(ran.status, 1) << ran.error;
    for (const std::string& line : proposed) EXPECT_TRUE(ran.out.contains(line)) << ran.out;
    const Ran patched = run_program({"patch", changed, folder.write("change.patch", ran.out)});
    ASSERT_EQ(patched.status, 0) << patched.out;
    const Ran checked = run({"check", changed});
    EXPECT_NE(checked.status, 2) << checked.error;
    EXPECT_FALSE(checked.out.contains(" error MLCCA")) << number << checked.out;
    EXPECT_EQ(run({"learn", log, "--merge", changed}).out, "") << "it is all described now";
  }
}

/// Every `step` ms, `count` lines.
std::string every(int step, int count, const std::string& frame) {
  std::string out;
  for (int i = 0; i < count; ++i) {
    const int ms = i * step;
    const std::string rest = std::to_string(1000 + ms % 1000).substr(1);
    out += "(" + std::to_string(1000 + ms / 1000) + "." + rest + "000) can0 " + frame + "\n";
  }
  return out;
}

TEST_F(LearnVerb, ChangedAttributesAreInThePatchAndCommentsOfPeopleStay) {
  const auto first = folder.write("slow.log", every(1000, 60, "310#11223344"));
  const auto path = folder.path("system.xml");
  ASSERT_EQ(run({"learn", first, "--output", path}).status, 0);
  const std::string described = content_of(path);
  const std::string list = R"(<Attributes period="1s" omission="1" maxPayload="4"/>)";
  const std::string commented =
      with(described, list,
           "<!-- of the pump --><Attributes omission=\"1\"\n      maxPayload='4' period=\"1s\"/>");
  const std::string own = with(
      with(described, list, R"(<Attributes omission="1" maxPayload="4" period="1s"/>)"),
      R"(channel="can0-310" network="can0"/>)",
      "channel=\"can0-310\" network=\"can0\"><!-- own -->\n    <Attributes period=\"900ms\"/>\n"
      "  </Publisher>");
  const auto faster = folder.write("fast.log", every(50, 600, "310#1122334455667788"));
  int number = 0;
  for (const std::string& text : {described, commented, own}) {
    const auto file = folder.write("is" + std::to_string(++number) + ".xml", text);
    const Ran ran = run({"learn", faster, "--merge", file});
    EXPECT_EQ(ran.status, 1) << ran.error;
    EXPECT_TRUE(ran.error.contains("differs: ")) << ran.error;
    EXPECT_TRUE(ran.out.contains("period=\"50ms\"")) << number << ran.out;
    const Ran patched = run_program({"patch", file, folder.write("change.patch", ran.out)});
    ASSERT_EQ(patched.status, 0) << patched.out << ran.out;
    const std::string now = content_of(file);
    for (const std::string comment : {"<!-- of the pump -->", "<!-- own -->"})
      EXPECT_EQ(now.contains(comment), text.contains(comment)) << comment << now;
    EXPECT_FALSE(now.contains("<!-- 60 events")) << now;
    EXPECT_TRUE(now.contains("<!-- 600 events, median gap 50ms")) << now;
    const Ran checked = run({"check", file});
    EXPECT_FALSE(checked.out.contains(" error MLCCA")) << number << checked.out;
    EXPECT_EQ(run({"learn", faster, "--merge", file}).status, 0)
        << "it is all described now" << now;
  }
}

TEST_F(LearnVerb, WhatComesMoreSeldomThanDescribedIsInThePatchToo) {
  const auto first = folder.write("fast.log", every(50, 600, "310#1122"));
  const auto path = folder.path("system.xml");
  ASSERT_EQ(run({"learn", first, "--output", path}).status, 0);
  const auto slower = folder.write("slow.log", every(500, 100, "310#1122"));
  const Ran ran = run({"learn", slower, "--merge", path});
  EXPECT_TRUE(ran.error.contains("it is reported as missing")) << ran.error;
  ASSERT_EQ(run_program({"patch", path, folder.write("change.patch", ran.out)}).status, 0);
  EXPECT_NE(run({"check", path}).status, 2);
  EXPECT_EQ(run({"learn", slower, "--merge", path}).status, 0) << content_of(path);
}

TEST_F(LearnVerb, WhatIsNotAsItIsDescribedIsSaid) {
  const auto path = drafted();
  const auto longer = folder.write("longer.log", frames("can0", "123", 8, 60));
  const Ran ran = run({"learn", longer, "--merge", path});
  EXPECT_EQ(ran.status, 1);
  EXPECT_TRUE(ran.error.contains("states MaxPayload 4 bytes, and 8 bytes were seen")) << ran.error;
  const auto other = folder.write("other.log", frames("can0", "321", 4, 60));
  const Ran silent = run({"learn", other, "--merge", path});
  EXPECT_TRUE(silent.error.contains("is described, and nothing of it was seen")) << silent.error;
  const auto elsewhere = folder.write("elsewhere.log", frames("can7", "321", 4, 60));
  const Ran unknown = run({"learn", elsewhere, "--merge", path});
  EXPECT_EQ(unknown.status, 2);
  EXPECT_TRUE(unknown.error.contains("no port of the gateway names the interface can7"))
      << unknown.error;
}

/// The lines, of which the first `shorter` have one byte and the others are unchanged.
std::string shortened(std::string lines, int shorter) {
  std::size_t at = 0;
  for (int i = 0; i < shorter; ++i) {
    at = lines.find('#', at) + 3;
    lines.erase(at, lines.find('\n', at) - at);
  }
  return lines;
}

TEST_F(LearnVerb, AFewEventsThatAreShorterThanTheOthersAreSaid) {
  const auto path = drafted();
  const std::string all = frames("can0", "123", 4, 400);
  const auto differs = [&](int shorter) {
    const Ran ran =
        run({"learn", folder.write("more.log", shortened(all, shorter)), "--merge", path});
    EXPECT_EQ(ran.status, ran.error.contains("differs:") ? 1 : 0) << ran.error;
    return ran.error;
  };
  EXPECT_FALSE(differs(0).contains("fewer bytes"));
  EXPECT_TRUE(
      differs(1).contains("1 of 400 events has fewer bytes than the others (1 at least, not 4): "
                          "no gate drops a frame for that"));
  EXPECT_TRUE(
      differs(4).contains("4 of 400 events have fewer bytes than the others (1 at least, "
                          "not 4)"));
  // No note about an event length that varies.
  EXPECT_FALSE(differs(5).contains("fewer bytes"));
}

TEST_F(LearnVerb, OfAnEthernetItDraftsWhatCheckTakes) {
  const auto trace = folder.write("eth0.pcap", datagrams(kDistance, 7, 8));
  const auto path = folder.path("system.xml");
  const Ran ran = run({"learn", trace, "--output", path});
  EXPECT_EQ(ran.status, 0) << ran.error;
  EXPECT_TRUE(
      ran.out.starts_with("eth0: 60 datagrams, profile famouso (99 % sure: 100 % of 60 "
                          "datagrams to ports 9999 and 8888 are events, 60 of them"))
      << ran.out;
  EXPECT_EQ(run({"check", path}).status, 0);
  EXPECT_EQ(run({"learn", trace, "--merge", path}).out, "") << "it is all described";
}

TEST_F(LearnVerb, OnEthernetChannelsAreFoundBySubjectWhateverTheirName) {
  const auto trace = folder.write("eth0.pcap", datagrams(kDistance, 7, 8));
  const auto path = folder.path("system.xml");
  ASSERT_EQ(run({"learn", trace, "--output", path}).status, 0);
  std::string text = content_of(path);
  for (std::size_t at = 0; (at = text.find("\"eth0-Distance\"")) != std::string::npos;)
    text.replace(at, 15, "\"distance\"");
  const auto renamed = folder.write("renamed.xml", text);
  const auto other = folder.write("eth0.pcapng", datagrams(kDistance, 9, 20));
  const Ran ran = run({"learn", other, "--merge", renamed});
  EXPECT_EQ(ran.status, 1);
  EXPECT_TRUE(
      ran.error.contains("distance (0x44697374616e6365 on eth0): 192.0.2.9 sends it, and "
                         "is not described as a publisher there"))
      << ran.error;
  EXPECT_TRUE(
      ran.out.contains("+  <Publisher name=\"eth0-Distance-of-192.0.2.9\" "
                       "channel=\"distance\" network=\"eth0\" address=\"192.0.2.9\""))
      << ran.out;
  const Ran patched = run_program({"patch", renamed, folder.write("change.patch", ran.out)});
  ASSERT_EQ(patched.status, 0) << patched.out;
  EXPECT_NE(run({"check", renamed}).status, 2) << "it is a description";
}

TEST_F(LearnVerb, WhatNowCrossesToABusIsBoundThere) {
  const auto trace = folder.write("eth0.pcap", datagrams(kDistance, 7, 4));
  std::string frames;
  for (unsigned i = 0; i < 60; ++i) {
    const std::string tenths = std::to_string(i % 10);
    const std::string byte =
        std::string(1, "0123456789ABCDEF"[i / 16]) + "0123456789ABCDEF"[i % 16];
    frames += "(" + std::to_string(100 + i / 10) + "." + tenths + "01000) can0 123#" + byte + byte +
              byte + byte + "\n";
  }
  const auto log = folder.write("can0.log", frames);
  const auto other = folder.write("other.log", "(100.0) can0 321#01\n");
  const auto path = folder.path("system.xml");
  ASSERT_EQ(run({"learn", trace, other, "--output", path}).status, 0);
  const Ran ran = run({"learn", trace, log, "--merge", path});
  EXPECT_EQ(ran.status, 1) << ran.error;
  EXPECT_TRUE(ran.error.contains("eth0-Distance: is on can0, and not bound there")) << ran.error;
  EXPECT_TRUE(
      ran.out.contains("+    <Binding channel=\"eth0-Distance\"><Identifier "
                       "form=\"standard\">0x123</Identifier></Binding>"))
      << ran.out;
  const Ran both = run({"learn", trace, log, "--json"});
  EXPECT_TRUE(both.out.contains(R"("crosses_to":["can0"])")) << both.out;
}

TEST_F(LearnVerb, AnInterfaceThatNoRecordingNamesIsSaid) {
  const auto trace = folder.write("trace.pcap", datagrams(kDistance, 7, 8));
  const Ran ran = run({"learn", trace});
  EXPECT_TRUE(ran.error.contains(
      "note: trace: its recording has no names of interfaces: state the one that it is"))
      << ran.error;
  EXPECT_TRUE(
      ran.out.contains("<!-- The recording has no name of this interface: state the one "
                       "that it is. -->\n    <Port network=\"trace\">"))
      << ran.out;
  const auto log = folder.write("first.log", frames("can0", "123", 4, 60));
  const Ran named = run({"learn", log});
  EXPECT_FALSE(named.error.contains("names of interfaces")) << named.error;
  EXPECT_FALSE(named.out.contains("name of this interface")) << named.out;
}

/// A log of a Vector tool with 60 frames on channel 1.
std::string vector_log(const std::string& id) {
  std::string out = "date Wed Apr 20 10:10:10 am 2016\nbase hex  timestamps absolute\n";
  for (unsigned i = 0; i < 60; ++i)
    out += "   " + std::to_string(100 + i / 10) + "." + std::to_string(i % 10) + "00 1  " + id +
           "  Rx   d 1 01\n";
  return out;
}

TEST_F(LearnVerb, TwoBusesStayTwoInWhateverOrderTheirRecordingsAreGiven) {
  const auto log = folder.write("a.log", frames("can1", "123", 4, 60));
  const auto one = folder.write("b.asc", vector_log("223"));
  const auto other = folder.write("c.asc", vector_log("224"));
  const Ran first = run({"learn", log, one, other});
  ASSERT_EQ(first.status, 0) << first.error;
  for (const char* name : {"can1-123", "can1-2-223", "can1-3-224"})
    EXPECT_TRUE(first.out.contains(std::string("<EventChannel name=\"") + name)) << first.out;
  EXPECT_TRUE(first.error.contains("note: can1-2: is can1 of " + one + "; its recording has no"))
      << first.error;
  EXPECT_TRUE(first.error.contains("note: can1-3: is can1 of " + other + "; its recording has no"))
      << first.error;
  for (const auto& order : {std::vector{one, log, other}, std::vector{other, one, log}}) {
    std::vector<std::string> command = {"learn"};
    command.insert(command.end(), order.begin(), order.end());
    EXPECT_EQ(run(command).out, first.out);
  }
  const Ran alone = run({"learn", one});
  EXPECT_TRUE(alone.error.contains("note: can1: its recording has no names")) << alone.error;
}

TEST_F(LearnVerb, WhatIsNoFileIsNotCreated) {
  const auto log = folder.write("first.log", frames("can0", "123", 4, 60));
  const Ran ran = run({"learn", log, "--output", "/dev/null"});
  EXPECT_EQ(ran.status, 0) << ran.error;
  EXPECT_FALSE(ran.out.contains("created")) << ran.out;
}

TEST_F(LearnVerb, ALogOfErrorFramesSaysWhatTheyAre) {
  std::string text;
  for (unsigned i = 0; i < 60; ++i)
    text += "(" + std::to_string(100 + i) + ".0) can0 20000080#0000000000000000\n";
  const auto log = folder.write("errors.log", text);
  EXPECT_EQ(refused({"learn", log}, {},
                    "60 error frames and no other: the bus was disturbed, or nobody acknowledged"),
            2);
}

TEST_F(LearnVerb, AProfileOfCanIsNoneOfAnEthernet) {
  const auto trace = folder.write("eth0.pcap", datagrams(kDistance, 7, 8));
  const Ran ran = run({"learn", trace, "--profile", "eth0=j1939"});
  EXPECT_EQ(ran.status, 0);
  EXPECT_TRUE(ran.error.contains("the profile j1939 is for CAN")) << ran.error;
  EXPECT_TRUE(ran.out.contains("<Profile>famouso</Profile>")) << ran.out;
}

}  // namespace
}  // namespace mlcca::test
