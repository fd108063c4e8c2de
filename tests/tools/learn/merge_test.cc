// SPDX-License-Identifier: BSD-2-Clause
// What `mlccactl learn --merge` proposes for a plant that is described: nothing that was not seen,
// and nothing that a check refuses without saying so.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/tools/design/describe/program.hpp"
#include "tests/tools/learn/pcap_file.hpp"
#include "tests/tools/learn/traffic.hpp"

namespace mlcca::test {
namespace {

/// A line of candump -l.
std::string line(std::uint64_t ms, const std::string& frame) {
  return fmt::format("({}.{:03}000) can0 {}\n", 1000 + ms / 1000, ms % 1000, frame);
}
/// `count` lines, one every `step` ms.
std::string lines(std::uint64_t step, std::uint64_t count, const std::string& frame) {
  std::string out;
  for (std::uint64_t i = 0; i < count; ++i) out += line(i * step, frame);
  return out;
}

struct LearnMerge : ::testing::Test {
  std::string drafted(const std::string& log, std::vector<std::string> more = {}) {
    const auto path = folder.path("system.xml");
    more.insert(more.begin(), {"learn", folder.write("first.log", log), "--output", path});
    const Ran ran = run(more);
    EXPECT_EQ(ran.status, 0) << ran.error;
    return path;
  }
  Ran merged(const std::string& log, const std::string& path) {
    return run({"learn", folder.write("second.log", log), "--merge", path});
  }
  /// Applies the patch.
  void apply(const Ran& ran, const std::string& path) {
    const Ran patched = run_program({"patch", path, folder.write("change.patch", ran.out)});
    ASSERT_EQ(patched.status, 0) << patched.out << ran.out;
  }
  Folder folder;
};

TEST_F(LearnMerge, FewEventsThatPassChangeNoPeriodAndNoProvision) {
  const auto path = drafted(lines(1000, 60, "310#1122"));
  for (const std::uint64_t count : {1, 2, 5, 31}) {
    const Ran ran = merged(lines(1000, count, "310#1122"), path);
    EXPECT_EQ(ran.status, 0) << count << ran.error;
    EXPECT_EQ(ran.out, "") << count;
  }
}

/// A cycle of so many ms, late by up to 4 % of it.
std::string cycle(std::uint64_t ms, std::uint64_t count, std::uint64_t seed,
                  std::uint64_t lost = 0) {
  std::mt19937_64 random(seed);
  std::string out;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t us = 1'000'000'000 + i * ms * 1000 + random() % (ms * 40);
    if (lost == 0 || i % lost != lost - 1)
      out += fmt::format("({}.{:06}) can0 310#11{:02X}\n", us / 1'000'000, us % 1'000'000, i % 256);
  }
  return out;
}

TEST_F(LearnMerge, ACycleThatIsAsDescribedIsNotChanged) {
  for (const std::uint64_t ms : {35U, 110U, 140U}) {
    const auto path = drafted(cycle(ms, 100, 1));
    const std::string described = fmt::format("period=\"{}ms\"", ms);
    EXPECT_TRUE(content_of(path).contains(described)) << content_of(path);
    for (std::uint64_t seed = 2; seed < 6; ++seed)
      for (const std::uint64_t lost : {0U, 25U}) {
        const Ran ran = merged(cycle(ms, 250, seed, lost), path);
        EXPECT_FALSE(ran.error.contains("would be dropped")) << ran.error;
        EXPECT_FALSE(ran.out.contains("period=")) << ran.out;
      }
    std::filesystem::remove(path);
  }
}

TEST_F(LearnMerge, TheCommentOfAChangedChannelSaysWhatWasSeenNow) {
  const std::string others = lines(500, 120, "120#55");
  const auto path = drafted(lines(100, 200, "310#11") + others);
  const Ran ran = merged(lines(50, 400, "310#11") + others, path);
  EXPECT_EQ(ran.status, 1) << ran.error;
  apply(ran, path);
  const std::string text = content_of(path);
  EXPECT_TRUE(
      text.contains("  <!-- 400 events, median gap 50ms, shortest 50ms, longest 50ms; "
                    "values were changed for this -->\n  <EventChannel name=\"can0-310\""))
      << text;
  EXPECT_FALSE(text.contains("200 events")) << text;
  EXPECT_TRUE(text.contains("<!-- 120 events, median gap 500ms")) << "not changed: " << text;
  EXPECT_EQ(merged(lines(50, 400, "310#11") + others, path).out, "");
}

TEST_F(LearnMerge, ASingleShortFrameIsNamed) {
  const auto path = drafted(lines(100, 60, "310#1122"));
  const Ran ran = merged(lines(100, 40, "310#1122") + line(4000, "310#11"), path);
  EXPECT_TRUE(
      ran.error.contains("1 of 41 events has fewer bytes than the others (1 at least, not 2)"))
      << ran.error;
  const Ran few = merged(lines(100, 18, "310#1122") + line(1800, "310#11"), path);
  EXPECT_FALSE(few.error.contains("fewer bytes")) << "of so few it may be usual";
}

TEST_F(LearnMerge, ACommentOfAPersonStays) {
  const std::string log = lines(100, 200, "310#11");
  const auto path = drafted(log);
  std::string text = content_of(path);
  const auto at = text.find("<!-- 200 events");
  text.replace(at, text.find("-->", at) - at, "<!-- The doors, seen by Anna. ");
  const auto changed = folder.write("changed.xml", text);
  const Ran ran = merged(lines(50, 400, "310#11"), changed);
  apply(ran, changed);
  EXPECT_TRUE(content_of(changed).contains("<!-- The doors, seen by Anna. -->"));
  EXPECT_TRUE(content_of(changed).contains("period=\"50ms\""));
}

TEST_F(LearnMerge, TheEndOfARecordingDoesNotContradictItsBegin) {
  std::string text = content_of("examples/learn/short.log");
  std::vector<std::string> all;
  for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1)
    all.push_back(text.substr(at, text.find('\n', at) + 1 - at));
  std::string first;
  std::string last;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i < 300) first += all[i];
    if (i >= 199) last += all[i];
  }
  const Ran ran = merged(last, drafted(first));
  EXPECT_EQ(ran.status, 0) << ran.error;
  EXPECT_EQ(ran.out, "");
}

TEST_F(LearnMerge, FewEventsOfWhichAGateDropsOneAreProposedAndSaid) {
  const std::string slow = lines(1000, 60, "310#1122");
  const std::string others = lines(500, 300, "120#55");
  const auto path = drafted(slow + others);
  std::string burst = others;
  for (const std::uint64_t ms : {60'000, 60'001, 60'002, 60'003}) burst += line(ms, "310#1122");
  const std::pair<std::string, const char*> cases[] = {
      {lines(100, 10, "310#1122"),
       "states Period 1 s, and 10 events, 100ms apart at least, were seen: frames would be "
       "dropped"},
      {burst,
       "states Period 1 s, and 4 events, 1ms apart at least, were seen: frames would be dropped"}};
  for (const auto& [log, says] : cases) {
    const auto copy = folder.write("copy.xml", content_of(path));
    const Ran ran = merged(log, copy);
    EXPECT_EQ(ran.status, 1);
    EXPECT_TRUE(ran.error.contains(says)) << ran.error;
    apply(ran, copy);
    EXPECT_EQ(run({"check", copy}).status, 0);
    const Ran again = merged(log, copy);
    EXPECT_EQ(again.out, "");
    EXPECT_FALSE(again.error.contains("frames would be dropped")) << again.error;
  }
}

TEST_F(LearnMerge, ElementsThatShareALineAreToldApart) {
  const std::string steady = lines(100, 60, "100#11");
  const auto path = drafted(steady + lines(200, 60, "2F0#22"));
  std::string text = content_of(path);
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos;) text[at] = ' ';
  const auto one_line = folder.write("one.xml", text);
  const Ran ran = merged(steady + lines(50, 120, "2F0#22"), one_line);
  EXPECT_EQ(ran.status, 1) << ran.error;
  EXPECT_TRUE(ran.error.contains("0x2f0 on can0): publisher can0-2F0 states Period")) << ran.error;
  apply(ran, one_line);
  const std::string patched = content_of(one_line);
  EXPECT_TRUE(patched.contains("<Attributes period=\"100ms\"")) << ran.out;
  EXPECT_FALSE(patched.contains("<Attributes period=\"200ms\"")) << ran.out;
  EXPECT_EQ(merged(steady + lines(50, 120, "2F0#22"), one_line).out, "") << ran.out;
}

TEST_F(LearnMerge, TheStatusSaysWhetherThereAreDifferencesInJsonToo) {
  const std::string known = lines(100, 60, "100#11");
  const auto path = drafted(known);
  const auto more = folder.write("more.log", known + lines(100, 60, "2F0#22"));
  const Ran differs = run({"learn", more, "--merge", path, "--json"});
  EXPECT_EQ(differs.status, 1);
  EXPECT_TRUE(differs.out.starts_with("{\"diff\":\"--- ")) << differs.out;
  EXPECT_EQ(differs.error, "");
  const Ran same = run({"learn", folder.path("first.log"), "--merge", path, "--json"});
  EXPECT_EQ(same.status, 0);
  EXPECT_TRUE(same.out.starts_with("{\"diff\":\"\",\"differs\":[]")) << same.out;
}

// --- the described profile -----------------------------------------------------------------------

TEST_F(LearnMerge, TheDescribedProfileRulesWhateverTheTrafficLooksLike) {
  const std::string known = lines(100, 60, "181#1122");
  const std::string foreign = lines(10, 3000, "18FEF100#1122334455667788");
  const auto path = drafted(known, {"--profile", "can0=canopen"});
  const std::string more = known + lines(100, 60, "282#11") + foreign;
  const Ran ran = merged(more, path);
  EXPECT_EQ(ran.status, 1) << ran.error;
  EXPECT_FALSE(ran.out.contains("<Identifier")) << ran.out;
  EXPECT_TRUE(ran.out.contains("+    <Binding channel=\"can0-cob-282\">")) << ran.out;
  EXPECT_TRUE(ran.error.contains("3000 frames that no channel of profile canopen can have"))
      << ran.error;
  apply(ran, path);
  const Ran checked = run({"check", path});
  EXPECT_EQ(checked.status, 0) << checked.out << checked.error;
  EXPECT_EQ(merged(more, path).out, "") << "it is all described now";
}

TEST_F(LearnMerge, AStatedProfileThatIsNotTheDescribedOneIsRefused) {
  const auto path = drafted(lines(100, 60, "181#1122"), {"--profile", "can0=canopen"});
  const auto log = folder.path("first.log");
  const Ran other = run({"learn", log, "--merge", path, "--profile", "can0=raw"});
  EXPECT_EQ(other.status, 2) << other.out;
  EXPECT_TRUE(other.error.contains("--profile can0=raw: " + path + " states canopen"))
      << other.error;
  EXPECT_EQ(run({"learn", log, "--merge", path, "--profile", "can0=canopen"}).status, 0);
}

TEST_F(LearnMerge, ANetworkThatCannotHaveTheTrafficIsLeftAsItIs) {
  const auto path = drafted(lines(100, 60, "181#1122"));
  learn::test::PcapFile file(1);
  for (std::uint64_t i = 0; i < 60; ++i) {
    const std::uint64_t ns = (100'000 + i * 100) * learn::test::kMs;
    file.add(ns, frame_of(learn::test::event(ns, 0, learn::test::kDistance, learn::test::station(7),
                                             {1, 2})));
  }
  const Ran ran = run({"learn", folder.write("can0.pcap", file.bytes()), "--merge", path});
  EXPECT_EQ(ran.out, "") << ran.error;
  EXPECT_TRUE(ran.error.contains(
      "note: can0: nothing is proposed for the network can0, which has the profile raw: the "
      "traffic is that of Ethernet with the profile famouso"))
      << ran.error;
}

/// A recording of events that go to a port of FAMOUSO.
std::string events_to(std::uint16_t port) {
  learn::test::PcapFile file(1);
  for (std::uint64_t i = 0; i < 60; ++i) {
    const std::uint64_t ns = (100'000 + i * 100) * learn::test::kMs;
    auto sent = learn::test::event(ns, 0, learn::test::kDistance, learn::test::station(7), {1, 2});
    sent.datagram->port = port;
    file.add(ns, frame_of(sent));
  }
  return file.bytes();
}

TEST_F(LearnMerge, ATransportThatIsNotTheDescribedOneIsSaid) {
  const auto path = folder.path("system.xml");
  ASSERT_EQ(run({"learn", folder.write("eth0.pcap", events_to(9999)), "--output", path}).status, 0);
  EXPECT_TRUE(content_of(path).contains("<Kind>udp-multicast</Kind>"));
  const Ran same = run({"learn", folder.path("eth0.pcap"), "--merge", path});
  EXPECT_EQ(same.status, 0) << same.error;
  EXPECT_FALSE(same.error.contains("Kind")) << same.error;
  const Ran other = run({"learn", folder.write("eth0.pcapng", events_to(8888)), "--merge", path});
  EXPECT_EQ(other.status, 1) << other.error;
  EXPECT_TRUE(other.error.contains(
      "eth0: subscribers of its Kind udp-multicast receive events of udp-multicast (port 9999), "
      "and 60 of 60 datagrams with events on eth0 are of udp-broadcast (port 8888): nobody "
      "receives them there"))
      << other.error;
}

// --- what check refuses of a patch ---------------------------------------------------------------

/// The note about the patched description; empty if there is none.
std::string refused_note(const Ran& ran) {
  const auto at =
      ran.error.find("note: 'mlccactl check' refuses a part of the patched description");
  return at == std::string::npos ? "" : ran.error.substr(at, ran.error.find('\n', at) - at);
}

TEST_F(LearnMerge, WhatCheckWouldRefuseOfThePatchIsSaid) {
  const std::string slow = lines(1000, 60, "310#1122");
  const auto path = drafted(slow, {"--bitrate", "can0=10k"});
  ASSERT_EQ(run({"check", path}).status, 0);
  const Ran ran = merged(slow + lines(10, 2000, "120#1122334455667788"), path);
  EXPECT_EQ(ran.status, 1);
  EXPECT_NE(refused_note(ran), "") << ran.error;
  apply(ran, path);
  const Ran checked = run({"check", path});
  EXPECT_EQ(checked.status, 1) << checked.out;
  EXPECT_TRUE(checked.out.contains("can0")) << checked.out;

  // What the description had before is not the patch's.
  const Ran more =
      merged(lines(10, 2000, "120#1122334455667788") + slow + lines(1000, 60, "7F0#11"), path);
  EXPECT_EQ(more.status, 1);
  EXPECT_TRUE(more.out.contains("can0-7F0")) << more.out;
  EXPECT_FALSE(refused_note(more).contains("can0-120")) << more.error;
}

TEST_F(LearnMerge, APatchThatCheckAcceptsHasNoNote) {
  const std::string slow = lines(1000, 60, "310#1122");
  const auto path = drafted(slow);
  const Ran ran = merged(slow + lines(100, 60, "120#11"), path);
  EXPECT_EQ(ran.status, 1);
  EXPECT_FALSE(ran.error.contains("mlccactl check")) << ran.error;
}

TEST_F(LearnMerge, OfIncludedFilesItSaysThatTheyAreNotChecked) {
  const std::string slow = lines(1000, 60, "310#1122");
  const auto path = drafted(slow);
  std::string text = content_of(path);
  const std::string end = "</Network>\n";
  const auto from = text.find("  <Network ");
  const auto to = text.find(end) + end.size();
  const std::string network = text.substr(from, to - from);
  text.replace(from, to - from,
               "<xi:include xmlns:xi=\"http://www.w3.org/2001/XInclude\" href=\"bus.xml\"/>\n");
  folder.write("bus.xml", network);
  const auto whole = folder.write("whole.xml", text);
  ASSERT_EQ(run({"check", whole}).status, 0);
  const Ran ran = merged(slow + lines(100, 60, "120#11"), whole);
  EXPECT_EQ(ran.status, 1) << ran.error;
  EXPECT_TRUE(ran.out.contains("bus.xml")) << ran.out;
  EXPECT_TRUE(ran.error.contains("note: the patch changes files that " + whole +
                                 " includes: run 'mlccactl check' when it is applied"))
      << ran.error;
}

}  // namespace
}  // namespace mlcca::test
