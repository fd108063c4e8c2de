// SPDX-License-Identifier: BSD-2-Clause
// docs/how-to/shared-closed.md shows what a gateway says in each state in which it closes shared
// networks, and what ends that.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "tests/daemon/gateway/members_rollout.hpp"
#include "tests/support/source_tree.hpp"

namespace mlcca::test {
namespace {

std::string page() {
  std::ifstream file(testing::source_tree() / "docs/how-to/shared-closed.md");
  return {std::istreambuf_iterator<char>(file), {}};
}

/// What a section shows of the state, in the names of the bench: by the name of a line.
using Shown = std::vector<std::pair<std::string, std::string>>;

/// The blocks of a section, in their order.
std::vector<Shown> shown_in(const std::string& section) {
  const std::string text = page();
  const auto begin = text.find("\n## " + section + "\n");
  EXPECT_NE(begin, std::string::npos) << section;
  if (begin == std::string::npos) return {};
  std::istringstream lines(text.substr(begin + 1, text.find("\n## ", begin + 1) - begin));
  std::vector<Shown> blocks;
  bool inside = false;
  for (std::string line; std::getline(lines, line);) {
    if (line == "```text") blocks.emplace_back();
    inside = line == "```text" || (inside && line != "```");
    constexpr std::size_t value = 14;
    if (!inside || line.size() < value || line.starts_with("```")) continue;
    line = std::regex_replace(line, std::regex("\\brobots\\b"), "pair");
    line = std::regex_replace(line, std::regex("\\blan\\b"), "shared");
    if (line.starts_with(' '))  // the page folds long lines
      blocks.back().back().second += ' ' + line.substr(value);
    else
      blocks.back().emplace_back(line.substr(0, line.find(' ')), line.substr(value));
  }
  return blocks;
}

/// "…" stands for any text.
bool fits(const std::string& pattern, const std::string& text) {
  const std::string any = "…";
  std::size_t at = 0;
  std::size_t from = 0;
  for (bool first = true;; first = false) {
    const std::size_t end = pattern.find(any, from);
    const std::string part = pattern.substr(from, end == std::string::npos ? end : end - from);
    const bool last = end == std::string::npos;
    const std::size_t found = first ? (text.starts_with(part) ? 0 : std::string::npos)
                              : last && text.ends_with(part) && text.size() >= at + part.size()
                                  ? text.size() - part.size()
                                  : text.find(part, at);
    if (found == std::string::npos) return false;
    at = found + part.size();
    if (last) return at == text.size();
    from = end + any.size();
  }
}

class SharedClosedPage : public MembersRollout {
 protected:
  control::Cluster cluster(std::size_t g) {
    const auto body = at(g).ask(control::ClusterRequest{}).reply.body;
    const auto* const found = std::get_if<control::Cluster>(&body);
    return found == nullptr ? control::Cluster{} : *found;
  }
  /// The state of the first gateway is as the page shows it.
  void expect(const std::string& section, std::size_t block = 0, std::size_t g = 0) {
    const auto blocks = shown_in(section);
    ASSERT_GT(blocks.size(), block) << section;
    const control::Cluster is = cluster(g);
    const std::string shared = is.shared == "open" ? "open: shared"
                               : is.shared == "described"
                                   ? "what is reserved is CLOSED, what is described is open: shared"
                                   : "CLOSED: shared";
    for (const auto& [name, value] : blocks[block]) {
      const auto shows = [&, &value = value](const std::string& text) { return fits(value, text); };
      if (name == "phase") {
        EXPECT_TRUE(shows(is.phase)) << section << ": " << is.phase;
      } else if (name == "shared") {
        EXPECT_TRUE(shows(shared)) << section << ": " << shared;
      } else {
        EXPECT_EQ(name, "problem");
        EXPECT_TRUE(std::ranges::any_of(is.health.reasons, shows))
            << section << ": " << ::testing::PrintToString(is.health.reasons);
      }
    }
  }
  void go_back() {
    const FakeStore backup = store;
    pass(5 * kSecondNs);
    for (auto& node : nodes) node->link.up = false;
    run();
    store = backup;
    for (auto& node : nodes) node->link.up = true;
    run();
  }
};

TEST_F(SharedClosedPage, TheStoreDoesNotAnswer) {
  start_both();
  link(0).up = false;
  run();
  expect("The store does not answer", 0);
  pass(12 * kSecondNs);
  expect("The store does not answer", 1);
  link(0).up = true;
  pass(5 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "in") << "it ends when it answers";
}

TEST_F(SharedClosedPage, TheGatewayJoins) {
  link(0).up = false;
  start(0);
  expect("The gateway joins");
}

TEST_F(SharedClosedPage, TheGatewayWasFenced) {
  start_both();
  link(0).answers = false;
  store.write({{.key = "/mlcca/pair/f/g0", .value = "g1"}});
  pass(kSecondNs);
  expect("The gateway was fenced");
  link(0).answers = true;
  pass(5 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "in") << "by itself";
}

TEST_F(SharedClosedPage, TheStoreHasGoneBackAndWhatIsLeftOfLeases) {
  start_both();
  go_back();
  expect("The store has gone back");
  store.write({{.key = "/mlcca/pair/e", .value = "0123456789abcdef"}});
  pass(kSecondNs);
  expect("Leases from before a restoration");
  pass(15 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "in") << "by itself";
}

TEST_F(SharedClosedPage, ADescriptionComesIntoForce) {
  start(0);
  pass(3 * kSecondNs);
  expect("A description comes into force", 0);
  start(1);
  pass(5 * kSecondNs);
  ASSERT_EQ(cluster(0).phase, "in");
  // The other one dies while both change.
  finish_reading = false;
  ASSERT_EQ(roll_out(0, "2"), "checking");
  run();
  at(0).reading().finish();
  run();
  at(1).reading().finish();
  for (int n = 0; n < 20 && !at(0).reading().busy(); ++n) pass(kStepNs);
  at(1).end();
  at(0).reading().finish();
  finish_reading = true;
  pass(30 * kSecondNs);
  expect("A description comes into force", 1);
  ASSERT_EQ(rolled(0, {.without = {"g1"}, .back = true}), "checking");
  pass(15 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "in");
  EXPECT_TRUE(has(0, 1));
  store.write({{.key = "/mlcca/pair/d/current", .value = "\xff"}});
  run();
  expect("A description comes into force", 2);
  start(1);
  store.write({}, {"/mlcca/pair/d/current"});
  pass(40 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "in") << "the gateways propose theirs again";
}

TEST_F(SharedClosedPage, TheClusterHasAnotherDescription) {
  at(1).digest = 7;
  start(0);
  pass(kSecondNs);
  ASSERT_EQ(roll_out(0, "1", {"g1"}), "checking");
  pass(5 * kSecondNs);
  start(1);
  pass(3 * kSecondNs);
  expect("The cluster has another description", 0, 1);
  EXPECT_TRUE(rolled(1, {.accept = true}).starts_with("description "));
  pass(5 * kSecondNs);
  EXPECT_EQ(cluster(1).phase, "in");
}

TEST_F(SharedClosedPage, TheGatewayIsDrained) {
  start_both();
  static_cast<void>(at(0).ask(control::DrainRequest{}));
  pass(3 * kSecondNs);
  expect("The gateway is drained");
  static_cast<void>(at(0).ask(control::JoinRequest{}));
  pass(3 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "in");
}

TEST_F(SharedClosedPage, AnEntryCannotBeRead) {
  start_both();
  store.write({{.key = "/mlcca/pair/r/shared/g1/7", .value = "not understood"}});
  run();
  expect("An entry cannot be read");
  at(1).end();
  start(1);
  pass(5 * kSecondNs);
  for (std::size_t g = 0; g < 2; ++g) EXPECT_TRUE(cluster(g).health.reasons.empty()) << g;
}

TEST_F(SharedClosedPage, TheStoreIsFull) {
  start_both();
  link(0).full = link(1).full = true;
  run();
  EXPECT_EQ(cluster(0).phase, "in") << "until the lease ends";
  pass(12 * kSecondNs);
  expect("The store is full");
  link(0).full = link(1).full = false;
  pass(5 * kSecondNs);
  EXPECT_EQ(cluster(0).phase, "in") << "there is room again";
}

TEST_F(SharedClosedPage, TheDescriptionIsNotChecked) {
  start_both();
  ASSERT_EQ(roll_out(0, "2"), "checking");
  pass(8 * kSecondNs);
  at(1).end();
  at(1).digest = 7;
  at(1).texts.damaged = {Sha256::Digest{2}};
  link(1).up = false;
  start(1);
  pass(kSecondNs);
  expect("The description is not checked", 0, 1);
}

TEST_F(SharedClosedPage, HasEachPhase) {
  const std::string text = page();
  for (const char* const phase :
       {"in", "joining", "silent", "fenced", "gone-back", "waiting", "description-pending",
        "other-description", "draining", "drained"})
    EXPECT_TRUE(std::regex_search(text, std::regex("\n- [^:\n]*`" + std::string(phase) + "`")))
        << phase;
}

}  // namespace
}  // namespace mlcca::test
