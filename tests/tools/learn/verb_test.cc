// SPDX-License-Identifier: BSD-2-Clause
// mlccactl learn as a user runs it, on recordings.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/tools/design/describe/program.hpp"

namespace mlcca::test {
namespace {

/// `count` frames of an identifier, one every 100 ms, of so many bytes.
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

struct LearnVerb : ::testing::Test {
  /// A description drafted from 60 frames of 0x123.
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
  EXPECT_EQ(again.status, 2);
  EXPECT_TRUE(again.error.contains("nothing is overwritten")) << again.error;
  EXPECT_EQ(content_of(path), before);
}

TEST_F(LearnVerb, SaysWhatCannotBeUsed) {
  const auto log = folder.write("first.log", frames("can0", "123", 4, 60));
  const std::pair<std::vector<std::string>, const char*> cases[] = {
      {{folder.path("nowhere.log")}, "there is neither such a file nor such an interface"},
      {{log, "--for", "soon"}, "--for: "},
      {{log, "--name", "a b"}, "--name: "},
      {{log, "--gateway", "<g>"}, "--gateway: "},
      {{log, "--profile", "can0=none"}, "write an interface and one of raw, famouso"},
      {{log, "--bitrate", "500k"}, "write can0=500k"},
      {{log, "--merge", folder.write("bad.xml", "<System/>")}, "cannot be used"}};
  for (const auto& [more, says] : cases) {
    std::vector<std::string> arguments{"learn"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Ran ran = run(arguments);
    EXPECT_EQ(ran.status, 2) << says << ran.out;
    EXPECT_TRUE(ran.error.contains(says)) << ran.error;
  }
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

}  // namespace
}  // namespace mlcca::test
