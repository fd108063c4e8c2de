// SPDX-License-Identifier: BSD-2-Clause
// The XSLT twin and the C++ checker find the same in thousands of random systems.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "description/read.hpp"
#include "tests/description/twin/random_description.hpp"
#include "tests/description/twin/twin.hpp"

namespace mlcca::testing {
namespace {

constexpr std::size_t kSystems = 2400;
constexpr std::uint64_t kFirstSeed = 1;

std::string difference(const Keys& a, const Keys& b) {
  std::vector<Key> only;
  std::ranges::set_difference(a, b, std::back_inserter(only));
  std::string out;
  for (const auto& key : only) out += "\n  " + to_string(key);
  return out;
}

bool is_note(const Key& key) { return key.id >= "MLCCA038"; }

TEST(Twin, FindsWhatTheCheckerFindsInRandomSystems) {
  const Folder folder;
  std::vector<std::string> texts;
  std::vector<std::string> files;
  for (std::size_t i = 0; i < kSystems; ++i) {
    texts.push_back(random_description(kFirstSeed + i));
    files.push_back(folder.add(std::to_string(i) + ".xml", texts.back()));
  }
  const auto twins = twin_findings(files);
  std::map<std::string, std::size_t> systems_with;  // an id or an attribute: in so many systems
  std::size_t clean = 0;
  for (std::size_t i = 0; i < kSystems; ++i) {
    SCOPED_TRACE("seed " + std::to_string(kFirstSeed + i));
    const auto system = description::read_memory(texts[i], "random.xml");
    if (!system) {
      for (const auto& problem : system.error()) ADD_FAILURE() << description::to_string(problem);
      ASSERT_LT(i, 0U) << texts[i];
    }
    const auto expected = findings_of(*system);
    const auto found = in_words(*system, twins[i]);
    ASSERT_TRUE(found == expected) << "only the twin:" << difference(found, expected)
                                   << "\nonly the checker:" << difference(expected, found) << "\n"
                                   << texts[i];
    clean += std::ranges::all_of(expected, is_note) ? 1 : 0;
    std::map<std::string, std::size_t> here;
    for (const auto& key : expected) here[key.id] = here[key.attribute] = 1;
    for (const auto& [what, once] : here) systems_with[what] += once;
  }
  // What both find in nothing, or in everything, would prove little.
  EXPECT_GE(clean, kSystems / 5);
  EXPECT_GE(kSystems - clean, kSystems / 5);
  for (const auto* id :
       {"MLCCA010", "MLCCA020", "MLCCA021", "MLCCA038", "MLCCA039", "MLCCA040", "MLCCA041"})
    EXPECT_GE(systems_with[id], kSystems / 40) << id;
  for (const auto& attribute : {"Latency", "Jitter", "Deadline", "Period", "Bandwidth",
                                "PacketLoss", "Omission", "MaxPayload", "Own0"})
    EXPECT_GE(systems_with[attribute], kSystems / 100) << attribute;
}

}  // namespace
}  // namespace mlcca::testing
