// SPDX-License-Identifier: BSD-2-Clause
// The stylesheet twin contradicts no other level, and takes nothing for fit by its silence.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/design/findings.hpp"
#include "core/model/system.hpp"
#include "tests/description/twin/twin.hpp"
#include "tests/levels/checked.hpp"

namespace mlcca::testing {
namespace {

constexpr std::uint64_t kTwins = 1200;  // of the systems

bool has_error(const Checked& checked, std::size_t channel) {
  for (const auto& f : checked.inspection.findings)
    if (f.channel == channel && core::info(f.id).severity == core::Severity::error) return true;
  return false;
}

TEST_F(Levels, TheTwinNeverContradictsCheck) {
  const Folder folder;
  std::vector<std::string> files;
  for (std::size_t i = 0; i < kTwins; ++i)
    files.push_back(folder.add(std::to_string(i) + ".xml", texts_[i]));
  const auto twins = twin_findings(files);
  std::size_t errors = 0;
  for (std::size_t i = 0; i < kTwins; ++i) {
    const auto& system = all_[i].system;
    for (const auto& key : twins[i]) {
      if (is_note(key)) continue;
      ++errors;
      const auto subscriber =
          std::ranges::find(system.subscribers, key.subscriber, &core::Subscriber::name);
      ASSERT_NE(subscriber, system.subscribers.end());
      EXPECT_TRUE(has_error(all_[i], subscriber->channel)) << to_string(key) << "\n" << texts_[i];
    }
  }
  EXPECT_GT(errors, kTwins / 10);
}

/// In one of the sets, so that check can refuse what the twin has nothing against.
bool states_too_little(const core::Publisher& publisher) {
  for (std::size_t set = 0; set <= publisher.lower.size(); ++set) {
    const AttributeSet& stated = core::attributes_in(publisher, set);
    if (!stated.has(Attribute::period) || !stated.has(Attribute::max_payload)) return true;
  }
  return false;
}

/// Where check refuses something, the twin has an error for the channel, or says that it does not
/// decide. What a note of every description says is left: identifiers, frames, and others; so is
/// what must be stated.
TEST_F(Levels, TheTwinIsSilentOnNothingThatCheckRefuses) {
  using enum core::FindingId;
  const Folder folder;
  std::vector<std::string> files;
  for (std::size_t i = 0; i < kTwins; ++i)
    files.push_back(folder.add(std::to_string(i) + ".xml", texts_[i]));
  const auto twins = twin_findings(files);
  const auto left = twin_left(files);
  std::size_t open = 0;
  for (std::size_t i = 0; i < kTwins; ++i) {
    const auto& system = all_[i].system;
    for (const core::Finding& f : all_[i].inspection.findings) {
      if (f.publisher == core::kNone || f.subscriber == core::kNone) continue;
      if (f.id != traffic_mismatch && f.id != hop_unfit && f.id != route_unfit &&
          f.id != deadline_missed && f.id != medium_time)
        continue;
      if (states_too_little(system.publishers[f.publisher])) continue;
      const std::string& publisher = system.publishers[f.publisher].name;
      const std::string& subscriber = system.subscribers[f.subscriber].name;
      const bool refuted = std::ranges::any_of(twins[i], [&](const Key& key) {
        return !is_note(key) && (key.subscriber == subscriber || key.publisher == publisher);
      });
      // Where the set is open, the notes are of those whom a lower one may serve.
      const bool is_left = std::ranges::any_of(system.publishers, [&](const auto& p) {
        return p.channel == f.channel && std::ranges::any_of(left[i], [&](const std::string& ends) {
                 return ends.starts_with(p.name + " ");
               });
      });
      open += is_left ? 1 : 0;
      ASSERT_TRUE(refuted || is_left) << core::code_of(f.id) << " " << f.text << "\n" << texts_[i];
    }
  }
  EXPECT_GT(open, kTwins / 10);
}

}  // namespace
}  // namespace mlcca::testing
