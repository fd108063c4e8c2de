// SPDX-License-Identifier: BSD-2-Clause
// Every file of tests/corpus/description is a case. A bad one says in comments which problems are
// found (expect: LINE: ELEMENT: REGEX), all of them; a good one states facts of the System that is
// read (expect-FACT: VALUE, see facts()).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "description/pattern.hpp"
#include "description/read.hpp"

namespace mlcca::description {
namespace {

std::vector<std::string> files(const std::string& folder) {
  std::vector<std::string> out;
  for (const auto& entry :
       std::filesystem::directory_iterator("tests/corpus/description/" + folder))
    if (entry.path().extension() == ".xml") out.push_back(entry.path().string());
  std::ranges::sort(out);
  return out;
}

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string case_name(const testing::TestParamInfo<std::string>& info) {
  auto name = std::filesystem::path(info.param).stem().string();
  std::ranges::replace(name, '-', '_');
  return name;
}

struct Expectation {
  int line;
  std::string element;
  std::string regex;

  [[nodiscard]] bool fits(const Problem& p) const {
    return p.line == line && p.element == element && Pattern(regex).matches_whole(p.text);
  }
};

std::vector<Expectation> expectations(const std::string& text) {
  const Pattern form("<!-- expect: ([0-9]+): ([A-Za-z]*): (.*) -->");
  std::vector<Expectation> out;
  for (auto& [line, element, regex] : form.find_all(text))
    out.push_back({std::stoi(line), element, regex});
  return out;
}

void add_attributes(std::set<std::string>& out, const std::string& owner, const AttributeSet& set) {
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const auto a = attribute_at(i);
    if (!set.has(a)) continue;
    out.insert(fmt::format("{} {} {}", owner, info(a).name, set[a]));
    if (owner.starts_with("provision"))
      out.insert(fmt::format("{}:{} {}", set.is_dynamic(a) ? "dynamic" : "static",
                             owner.substr(owner.find(':') + 1), info(a).name));
  }
}

/// What can be stated, as "name: value"; lists begin with the index of the entry.
std::set<std::string> facts(const core::System& s) {
  std::set<std::string> out{fmt::format("channels: {}", s.channels.size()),
                            fmt::format("networks: {}", s.networks.size()),
                            fmt::format("gateways: {}", s.gateways.size()),
                            fmt::format("publishers: {}", s.publishers.size()),
                            fmt::format("subscribers: {}", s.subscribers.size())};
  for (std::size_t i = 0; i < s.channels.size(); ++i) {
    out.insert(fmt::format("subject: {} 0x{:x}", i, s.channels[i].subject));
    out.insert(fmt::format("channel-text: {} {}", i, s.channels[i].description));
    add_attributes(out, fmt::format("channel-attribute: {}", i), s.channels[i].attributes);
  }
  for (std::size_t i = 0; i < s.networks.size(); ++i) {
    out.insert(fmt::format("bindings: {} {}", i, s.networks[i].bindings.size()));
    add_attributes(out, fmt::format("provision: {}", i), s.networks[i].provision);
  }
  for (std::size_t i = 0; i < s.gateways.size(); ++i)
    out.insert(fmt::format("ports: {} {}", i, s.gateways[i].ports.size()));
  for (std::size_t i = 0; i < s.publishers.size(); ++i) {
    const auto& p = s.publishers[i];
    out.insert(fmt::format("publisher-name: {} {}", i, p.name));
    out.insert(fmt::format("priority: {} {}", i, p.priority));
    if (p.node) out.insert(fmt::format("node: {} {}", i, *p.node));
    if (p.uid) out.insert(fmt::format("uid: {} {}", i, *p.uid));
    add_attributes(out, fmt::format("publisher-attribute: {}", i), p.attributes);
  }
  for (std::size_t i = 0; i < s.subscribers.size(); ++i)
    add_attributes(out, fmt::format("subscriber-attribute: {}", i), s.subscribers[i].attributes);
  return out;
}

class BadDescription : public testing::TestWithParam<std::string> {};

TEST_P(BadDescription, IsRefusedWithExactlyTheExpectedProblems) {
  const auto expected = expectations(text_of(GetParam()));
  ASSERT_FALSE(expected.empty()) << GetParam() << " states no expectation";
  const auto result = read(GetParam());
  ASSERT_FALSE(result) << GetParam() << " was read without a problem";
  auto problems = result.error();
  EXPECT_TRUE(std::ranges::is_sorted(problems, {}, &Problem::line));
  for (const auto& e : expected) {
    const auto found = std::ranges::find_if(problems, [&](const Problem& p) { return e.fits(p); });
    if (found == problems.end())
      ADD_FAILURE() << "not found: " << e.line << ": " << e.element << ": " << e.regex;
    else
      problems.erase(found);
  }
  for (const auto& p : problems) ADD_FAILURE() << "not expected: " << to_string(p);
}

INSTANTIATE_TEST_SUITE_P(Corpus, BadDescription, testing::ValuesIn(files("bad")), case_name);

class GoodDescription : public testing::TestWithParam<std::string> {};

TEST_P(GoodDescription, IsReadAsItsFactsSay) {
  const auto result = read(GetParam());
  if (!result)
    for (const auto& p : result.error()) ADD_FAILURE() << to_string(p);
  ASSERT_TRUE(result);
  const auto stated = facts(*result);
  const auto text = text_of(GetParam());
  const auto expected = Pattern("expect-([a-z-]+: .*)").find_all(text);
  for (const auto& fact : expected) EXPECT_TRUE(stated.contains(fact[0])) << fact[0];
  EXPECT_FALSE(expected.empty()) << GetParam() << " states no fact";
}

INSTANTIATE_TEST_SUITE_P(Corpus, GoodDescription, testing::ValuesIn(files("good")), case_name);

}  // namespace
}  // namespace mlcca::description
