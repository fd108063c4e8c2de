// SPDX-License-Identifier: BSD-2-Clause
// Every file of tests/tools/design/check/cases is a description with what must be found in it, and
// nothing else:
// <!-- expect: MLCCA013 line 12 Latency --> (the attribute only where there is one), or
// <!-- expect: clean -->. Each NAME.xml has a NAME-good.xml beside it, which is clean.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/design/findings.hpp"
#include "tests/tools/design/check/program.hpp"
#include "tools/design/check/report.hpp"

namespace mlcca {
namespace {

using Json = nlohmann::json;
using Lines = std::multiset<std::string>;

const std::filesystem::path kFolder = "tests/tools/design/check/cases";

std::vector<std::string> cases() {
  std::vector<std::string> out;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder))
    if (entry.path().extension() == ".xml") out.push_back(entry.path().stem().string());
  std::ranges::sort(out);
  return out;
}

std::string path_of(const std::string& name) { return (kFolder / (name + ".xml")).string(); }

/// "MLCCA013 line 12 Latency"
Lines expected_of(const std::string& name) {
  Lines out;
  std::istringstream text(test::content_of(path_of(name)));
  const std::string before = "<!-- expect: ";
  for (std::string line; std::getline(text, line);)
    if (line.starts_with(before))
      out.insert(line.substr(before.size(), line.find(" -->") - before.size()));
  return out;
}

Lines found_by(const test::RunOutcome& outcome) {
  Lines out;
  const auto report = Json::parse(outcome.out);
  for (const auto& f : report.at("findings"))
    out.insert(f.at("id").get<std::string>() + fmt::format(" line {}", f.value("line", 0)) +
               (f.contains("attribute") ? " " + f["attribute"].get<std::string>() : ""));
  return out;
}

/// As documented: 2 where a file cannot be read, 1 for errors and warnings, 0 otherwise.
int status_for(const Lines& expected) {
  int status = 0;
  for (const auto& line : expected) {
    if (line == "clean") continue;
    const auto number = static_cast<std::size_t>(std::stoi(line.substr(5, 3)));
    const auto& info = core::finding_table()[number - 1];
    const bool unreadable = info.id <= core::FindingId::not_in_schema;
    status = std::max(status, unreadable ? 2 : info.severity == core::Severity::note ? 0 : 1);
  }
  return status;
}

class Case : public ::testing::TestWithParam<std::string> {};

TEST_P(Case, IsFoundExactly) {
  const auto expected = expected_of(GetParam());
  ASSERT_FALSE(expected.empty()) << "states no expectation";
  const auto outcome = test::run({"check", "--json", path_of(GetParam())});
  EXPECT_EQ(found_by(outcome), expected == Lines{"clean"} ? Lines{} : expected) << outcome.out;
  EXPECT_EQ(outcome.status, status_for(expected));
  EXPECT_EQ(outcome.error, "");
}

std::string case_name(const ::testing::TestParamInfo<std::string>& info) {
  auto name = info.param;
  std::ranges::replace(name, '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Corpus, Case, ::testing::ValuesIn(cases()), case_name);

TEST(CasesTest, EveryKindOfFindingHasACaseThatYieldsNothingElse) {
  std::set<std::string> alone;
  for (const auto& name : cases())
    if (const auto lines = expected_of(name); lines.size() == 1)
      alone.insert(lines.begin()->substr(0, 8));
  alone.insert(core::code_of(core::FindingId::not_decided));  // of the stylesheet alone
  // Something is refused there, which another finding says.
  alone.insert(core::code_of(core::FindingId::refused_on_bus));
  for (const auto& info : core::finding_table())
    EXPECT_TRUE(alone.contains(core::code_of(info.id))) << core::code_of(info.id);
}

TEST(CasesTest, WhatNobodyUsesIsNotCalledFit) {
  for (const char* const name : {"unused-channel", "unused-publisher"}) {
    const auto outcome = test::run({"check", path_of(name)});
    EXPECT_NE(
        outcome.out.find("1 channel: 0 fit, 0 decided at run time, 0 do not fit, 1 without use"),
        std::string::npos)
        << outcome.out;
  }
}

TEST(CasesTest, EveryCaseHasACleanTwin) {
  const auto all = cases();
  for (const auto& name : all) {
    if (name.ends_with("-good"))
      EXPECT_EQ(expected_of(name), Lines{"clean"}) << name;
    else
      EXPECT_TRUE(std::ranges::find(all, name + "-good") != all.end()) << name;
  }
}

/// `text` in words with one space between them: where its lines break does not matter.
std::string in_words(const std::string& text) {
  std::istringstream stream(text);
  std::string result;
  for (std::string word; stream >> word;) result += word + " ";
  return result;
}

/// A section for each kind: its number, name and severity, then title and advice as sentences.
TEST(CatalogueTest, TheDocumentationListsEveryKindOfFinding) {
  const auto page = test::content_of("docs/reference/check.md");
  const auto text = in_words(page);
  std::size_t sections = 0;
  for (auto at = page.find("\n### MLCCA"); at != std::string::npos;
       at = page.find("\n### MLCCA", at + 1))
    ++sections;
  EXPECT_EQ(sections, core::finding_table().size());
  for (const auto& info : core::finding_table()) {
    std::string title(info.title);
    title[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(title[0])));
    const auto section =
        in_words(fmt::format("### {} {} ({})\n\n{}. {}", core::code_of(info.id), info.name,
                             tools::design::to_text(info.severity), title, info.advice));
    EXPECT_TRUE(text.contains(section)) << section;
  }
}

}  // namespace
}  // namespace mlcca
