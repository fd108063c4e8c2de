// SPDX-License-Identifier: BSD-2-Clause
// The manual page and the shell completion know what the program knows.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "tests/control/messages.hpp"
#include "tests/control/server.hpp"
#include "tests/support/source_tree.hpp"
#include "tests/tools/run.hpp"

namespace mlcca {
namespace {

using Words = std::set<std::string>;

Words words_of(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

/// "--socket" and its like, wherever they are in `text`.
Words options_in(const std::string& text) {
  Words result;
  for (auto at = text.find("--"); at != std::string::npos; at = text.find("--", at + 2)) {
    const auto end = text.find_first_not_of("abcdefghijklmnopqrstuvwxyz-", at);
    result.insert(text.substr(at, end - at));
  }
  return result;
}

/// The first words of the indented lines of `text`.
Words entries_in(const std::string& text) {
  Words result;
  for (auto at = text.find("\n  "); at != std::string::npos; at = text.find("\n  ", at + 3))
    if (text[at + 3] != ' ') result.insert(text.substr(at + 3, text.find(' ', at + 3) - at - 3));
  return result;
}

/// Of the help of the program and of every verb. Some verbs are carried out by other
/// programs; those that have a manual page of their own describe their options there.
struct Help {
  Words verbs;
  Words options;
};
const Words kDoctor{"doctor"};
const Words kDesign{"analyse-bus", "check",  "describe", "export", "format",
                    "generate",    "import", "learn",    "new"};
const Words kOwnPage{"describe", "export", "generate", "import", "learn", "new"};

Help help() {
  const auto text = test::run_mlccactl({"--help"}).out;
  Help result;
  const auto verbs = text.find("Subcommands:");
  result.verbs = entries_in(text.substr(verbs, text.find("\n\n", verbs) - verbs));
  result.options = options_in(text);
  for (const auto& verb : result.verbs)
    if (!kOwnPage.contains(verb))
      result.options.merge(options_in(test::run_mlccactl({verb, "--help"}).out));
  return result;
}

/// What a manual page describes: the lines behind .TP and .TQ without quotes and escapes.
std::vector<std::string> manual_entries(const std::string& page) {
  std::ifstream file(mlcca::testing::source_tree() / "docs/man" / page);
  EXPECT_TRUE(file) << page;
  std::vector<std::string> result;
  bool follows = false;
  for (std::string line; std::getline(file, line);) {
    std::erase(line, '\\');
    std::erase(line, '"');
    if (follows) result.push_back(line.substr(line.find(' ') + 1));
    follows = line == ".TP" || line == ".TQ";
  }
  return result;
}

/// `text` as one word of a shell.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

/// What bash offers for the last of `words`, with the daemon at `socket`.
Words completions(const std::string& words, const std::string& socket) {
  const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path();
  const std::string script =
      "export PATH=" + program.string() + ":$PATH MLCCA_SOCKET=" + socket + "; . " +
      (mlcca::testing::source_tree() / "tools/completion/mlccactl.bash").string() +
      "; COMP_WORDS=(" + words +
      "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _mlccactl;"
      " printf '%s\\n' \"${COMPREPLY[@]}\"";
  const std::unique_ptr<FILE, FreeWith<::pclose>> bash(
      ::popen(("bash -c " + quoted(script)).c_str(), "r"));
  std::string text;
  std::array<char, 4096> piece{};
  while (const auto n = std::fread(piece.data(), 1, piece.size(), bash.get()))
    text.append(piece.data(), n);
  return words_of(text);
}

TEST(DocumentationTest, ManualDescribesEveryVerbAndOption) {
  const auto entries = manual_entries("mlccactl.1");
  const auto known = help();
  ASSERT_GT(known.verbs.size(), 15U);
  ASSERT_GT(known.options.size(), 15U);
  for (const auto& verb : known.verbs)
    EXPECT_TRUE(std::ranges::any_of(entries, [&](const std::string& entry) {
      return words_of(entry.substr(0, entry.find(' '))) == Words{verb};
    })) << verb;
  for (const auto& option : known.options)
    EXPECT_TRUE(std::ranges::any_of(entries, [&](const std::string& entry) {
      return options_in(entry).contains(option);
    })) << option;
}

/// Options that a manual page describes under ".SS Options of VERB and VERB", by verb.
std::map<std::string, Words> options_by_verb(const std::string& page) {
  std::ifstream file(mlcca::testing::source_tree() / "docs/man" / page);
  std::map<std::string, Words> result;
  Words verbs;
  bool follows = false;
  for (std::string line; std::getline(file, line);) {
    std::erase(line, '\\');
    std::erase(line, '"');
    const std::string head = ".SS Options of ";
    if (line.starts_with(".S")) verbs.clear();
    if (line.starts_with(head)) {
      verbs = words_of(line.substr(head.size()));
      verbs.erase("and");
    }
    for (const auto& verb : verbs)
      if (follows) result[verb].merge(options_in(line));
    follows = line == ".TP" || line == ".TQ";
  }
  return result;
}

TEST(DocumentationTest, ManualDescribesTheOptionsOfEachVerbAndNoOthers) {
  const auto described = options_by_verb("mlccactl.1");
  for (const auto& verb : help().verbs) {
    if (kOwnPage.contains(verb)) continue;
    auto expected = options_in(test::run_mlccactl({verb, "--help"}).out);
    for (const auto* common : {"--help", "--json", "--no-color", "--socket", "--timeout"})
      expected.erase(common);
    const auto found = described.find(verb);
    EXPECT_EQ(found == described.end() ? Words() : found->second, expected) << verb;
  }
}

TEST(DocumentationTest, APageOfItsOwnDescribesEveryOptionOfAVerb) {
  for (const auto& verb : kOwnPage) {
    const auto entries = manual_entries("mlccactl-" + verb + ".1");
    const auto options = options_in(test::run_mlccactl({verb, "--help"}).out);
    ASSERT_GT(options.size(), 1U) << verb;
    for (const auto& option : options)
      EXPECT_TRUE(std::ranges::any_of(
          entries, [&](const std::string& entry) { return options_in(entry).contains(option); }))
          << verb << " " << option;
  }
}

TEST(DocumentationTest, CompletionOffersEveryVerb) {
  EXPECT_EQ(completions("mlccactl s", "/nonexistent"), (Words{"status", "subscriptions"}));
  auto expected = help().verbs;
  expected.merge(options_in("--socket --timeout --json --no-color --help --version"));
  EXPECT_EQ(completions("mlccactl \"\"", "/nonexistent"), expected);
}

TEST(DocumentationTest, CompletionOffersEveryOptionOfAVerb) {
  for (const auto& verb : help().verbs) {
    auto expected = options_in(test::run_mlccactl({verb, "--help"}).out);
    // Without a daemon there is no socket.
    expected.merge(options_in(kDoctor.contains(verb) ? "--json --help"
                              : kDesign.contains(verb)
                                  ? "--json --no-color --help"
                                  : "--socket --timeout --json --no-color --help"));
    EXPECT_EQ(completions("mlccactl " + verb + " --", "/nonexistent"), expected) << verb;
  }
}

TEST(DocumentationTest, CompletionOffersFilesAndFormsToCheck) {
  EXPECT_EQ(completions("mlccactl check --format s", "/nonexistent"), (Words{"sarif"}));
  const auto folder =
      (mlcca::testing::source_tree() / "examples/volksbot/").lexically_normal().string();
  const auto offered = completions("mlccactl check " + folder, "/nonexistent");
  EXPECT_TRUE(offered.contains(folder + "system.xml"));
  EXPECT_FALSE(offered.contains(folder + "demo")) << "it is no description";
}

TEST(DocumentationTest, CompletionOffersWhatImportTakes) {
  EXPECT_EQ(completions("mlccactl import a.dbc --format d", "/nonexistent"), (Words{"dbc"}));
  EXPECT_EQ(completions("mlccactl import a.dbc --profile \"\"", "/nonexistent"),
            (Words{"raw", "j1939"}));
}

TEST(DocumentationTest, CompletionOffersWhatExportTakes) {
  EXPECT_EQ(completions("mlccactl export a.xml --format \"\"", "/nonexistent"),
            (Words{"dbc", "can-gw", "em_canid", "wireshark"}));
}

TEST(DocumentationTest, CompletionOffersWhatDescribeTakes) {
  EXPECT_EQ(completions("mlccactl describe a.xml --set Pe", "/nonexistent"), (Words{"Period="}));
  EXPECT_EQ(completions("mlccactl describe a.xml --unset Pe", "/nonexistent"), (Words{"Period"}));
  EXPECT_EQ(completions("mlccactl describe a.xml --safe-side \"\"", "/nonexistent"),
            (Words{"drop", "deliver", "none"}));
}

TEST(DocumentationTest, CompletionAsksTheDaemonForNames) {
  test::Server server([](const control::Request& request) {
    if (std::holds_alternative<control::NetworksRequest>(request.body))
      return test::Server::Answer{{{0, test::full_networks()}}};
    return test::Server::Answer{{{0, control::Channels{{test::refused_channel()}}}}};
  });
  EXPECT_EQ(completions("mlccactl explain em", server.path()), (Words{"emergency-switch"}));
  EXPECT_EQ(completions("mlccactl query a --from \"\"", server.path()),
            (Words{"robot-can", "mesh", "bridge", "second-bridge"}));
  EXPECT_EQ(completions("mlccactl query a --require Pe", server.path()), (Words{"Period="}));
  EXPECT_EQ(completions("mlccactl mode a", server.path()), (Words{"audit"}));
}

}  // namespace
}  // namespace mlcca
