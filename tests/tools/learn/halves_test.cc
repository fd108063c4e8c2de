// SPDX-License-Identifier: BSD-2-Clause
// Recordings of real traffic: what is drafted of the first half lets the second half pass, and not
// what does not belong there. With MLCCA_RECORDINGS=DIRECTORY those of other people, too.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tests/tools/learn/drafted.hpp"
#include "tools/learn/recording.hpp"

namespace mlcca::learn {
namespace {

using test::Gate;
using test::Sent;

/// Of the first interface of a recording: what crosses to others is sent by the gateway itself.
std::vector<Sent> frames_of(const std::string& path, std::vector<std::string>& names) {
  std::vector<Sent> all;
  Interfaces interfaces;
  const auto read = read_recording(path, interfaces, [&](const Frame& f) {
    if (f.interface != 0 || (f.id & kError) != 0) return;
    all.push_back({.ns = f.ns,
                   .interface = 0,
                   .id = f.id,
                   .data = {f.data.begin(), f.data.end()},
                   .fd = f.fd});
  });
  EXPECT_TRUE(read) << read.error().text;
  names = {interfaces.names().at(0)};
  return all;
}

/// Recordings of which more is dropped, but less than 1 %, by the names of their files, and why.
struct Exception {
  std::string_view file;
  std::string_view why;
};
constexpr std::array<Exception, 2> kExceptions{{
    {"civic_19_type_r_turnonanddrive.log",
     "the bus sleeps for most of the first half, in which slow messages come 2 to 9 times"},
    {"vabsubaru_keyonYESecu.log", "the ignition is switched on in the second half"},
}};

/// Whether the bus has set the times, not who has read the frames from an adapter some time later.
bool has_times_of_the_bus(const Draft& draft) {
  return std::ranges::none_of(draft.left_out, [](const std::string& note) {
    return note.contains("the times are not those of the bus");
  });
}

bool is_exception(const std::string& path) {
  const auto name = std::filesystem::path(path).filename();
  return std::ranges::find(kExceptions, std::string_view(name.native()), &Exception::file) !=
         kExceptions.end();
}

std::vector<std::string> recordings() {
  std::vector<std::string> paths = {"examples/learn/short.log"};
  if (const char* const more = std::getenv("MLCCA_RECORDINGS"); more != nullptr)
    for (const auto& file : std::filesystem::directory_iterator(more))
      paths.push_back(file.path().string());
  return paths;
}

TEST(Halves, TheSecondHalfOfARecordingPassesAndAttacksDoNot) {
  for (const std::string& path : recordings()) {
    std::vector<std::string> names;
    const std::vector<Sent> all = frames_of(path, names);
    ASSERT_FALSE(all.empty()) << path;
    const std::uint64_t middle = all.front().ns + (all.back().ns - all.front().ns) / 2;
    const std::vector<Sent> first = test::before(all, middle);
    ASSERT_FALSE(first.empty()) << path << ": all of it is its second half";
    std::set<std::uint32_t> seen;
    for (const Sent& one : first) seen.insert(one.id);
    const Draft draft = test::drafted(first, {}, names);
    Gate gate(draft);
    const test::Share all_dropped = test::from(all, middle, gate, [](const Sent&) { return true; });
    Gate gate_of_known(draft);
    const test::Share dropped = test::from(all, middle, gate_of_known,
                                           [&](const Sent& one) { return seen.contains(one.id); });
    std::printf(
        "%s: %zu frames, %zu channels; of the second half %llu of %llu dropped, of identifiers of "
        "the first half %llu of %llu\n",
        path.c_str(), all.size(), draft.channels.size(),
        static_cast<unsigned long long>(all_dropped.frames),
        static_cast<unsigned long long>(all_dropped.of),
        static_cast<unsigned long long>(dropped.frames),
        static_cast<unsigned long long>(dropped.of));
    if (!has_times_of_the_bus(draft))
      std::printf("%s: its times are not those of the bus\n", path.c_str());
    else
      EXPECT_LT(dropped.frames * (is_exception(path) ? 100 : 1000), dropped.of) << path;
    const std::uint64_t later = all.back().ns + test::kSecond;
    const Sent& known = first.front();
    EXPECT_FALSE(gate.passes({.ns = later, .id = 0x7fd, .data = {1}})) << path << ": unknown";
    std::uint64_t passed = 0;
    for (std::uint64_t i = 0; i < 100'000; ++i)
      passed += gate.passes({.ns = later + i * 1000, .id = known.id, .data = known.data}) ? 1 : 0;
    EXPECT_LT(passed, 10'000U) << path << ": a flood";
    Sent longer = known;
    longer.ns = later + test::kSecond;
    longer.data.resize(64);
    EXPECT_FALSE(gate.passes(longer)) << path << ": too long";
  }
}

}  // namespace
}  // namespace mlcca::learn
