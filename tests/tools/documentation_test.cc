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
#include <utility>
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
constexpr const char* kCommon = "--socket --timeout --json --no-color --help";
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

/// What `command` prints, with mlccactl of this build and the daemon at `socket`.
std::string output_of(const std::string& command, const std::string& socket) {
  const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path();
  const auto environment =
      "export PATH=" + program.string() + ":$PATH MLCCA_SOCKET=" + socket + "; timeout 60 ";
  const std::unique_ptr<FILE, FreeWith<::pclose>> shell(
      ::popen((environment + command).c_str(), "r"));
  std::string text;
  std::array<char, 4096> piece{};
  while (const auto n = std::fread(piece.data(), 1, piece.size(), shell.get()))
    text.append(piece.data(), n);
  return text;
}

/// What bash offers for the last of `words`, with the daemon at `socket`.
Words completions(const std::string& words, const std::string& socket) {
  const std::string script =
      ". " + (mlcca::testing::source_tree() / "tools/completion/mlccactl.bash").string() +
      "; COMP_WORDS=(" + words +
      "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _mlccactl;"
      " printf '%s\\n' \"${COMPREPLY[@]}\"";
  return words_of(output_of("bash -c " + quoted(script), socket));
}

/// What zsh or fish offers at the end of each of `lines`. One shell for all: it takes long to
/// start.
std::vector<Words> offered_by(const std::string& shell, const std::vector<std::string>& lines,
                              const std::string& socket = "/nonexistent") {
  const auto& tree = mlcca::testing::source_tree();
  auto command = (tree / "tests/tools" / (shell + "-completions")).string() + " " +
                 (tree / "tools/completion").string();
  for (const auto& line : lines) command += " " + quoted(line);
  std::istringstream printed(output_of(command, socket));
  std::vector<Words> result;
  Words words;
  for (std::string line; std::getline(printed, line);) {
    if (line == "end")
      result.push_back(std::exchange(words, {}));
    else
      words.insert(line);
  }
  result.resize(lines.size());
  return result;
}

/// What is offered behind a verb and "--". Without a daemon there is no socket.
Words options_behind(const std::string& verb) {
  auto options = options_in(test::run_mlccactl({verb, "--help"}).out);
  options.merge(options_in(kDoctor.contains(verb)   ? "--json --help"
                           : kDesign.contains(verb) ? "--json --no-color --help"
                                                    : kCommon));
  return options;
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
  expected.merge(options_in(std::string(kCommon) + " --version"));
  EXPECT_EQ(completions("mlccactl \"\"", "/nonexistent"), expected);
}

TEST(DocumentationTest, CompletionOffersEveryOptionOfAVerb) {
  for (const auto& verb : help().verbs)
    EXPECT_EQ(completions("mlccactl " + verb + " --", "/nonexistent"), options_behind(verb))
        << verb;
}

class ShellTest : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Documentation, ShellTest, ::testing::Values("zsh", "fish"),
                         [](const auto& shell) { return std::string(shell.param); });

TEST_P(ShellTest, OffersEveryVerbAndEveryOptionOfAVerbAndNoOthers) {
  const auto verbs = help().verbs;
  std::vector<std::string> lines{"mlccactl ", "mlccactl --", "mlccactl gate --verify --"};
  for (const auto& verb : verbs) lines.push_back("mlccactl " + verb + " --");
  const auto offered = offered_by(GetParam(), lines);
  EXPECT_EQ(offered[0], verbs);
  EXPECT_EQ(offered[1], options_in(std::string(kCommon) + " --version"));
  auto verifying = options_in("--json " + test::run_mlccactl({"gate", "--verify", "--help"}).out);
  auto offered_there = offered[2];
  for (auto* options : {&verifying, &offered_there}) options->erase("--verify");  // it stands there
  EXPECT_EQ(offered_there, verifying);
  std::size_t at = 3;
  for (const auto& verb : verbs) EXPECT_EQ(offered[at++], options_behind(verb)) << verb;
}

TEST_P(ShellTest, OffersWhatOptionsTake) {
  const auto folder =
      (mlcca::testing::source_tree() / "examples/volksbot/").lexically_normal().string();
  const auto offered =
      offered_by(GetParam(), {"mlccactl check --format s", "mlccactl import a.dbc --profile ",
                              "mlccactl export a.xml --format ", "mlccactl describe a.xml --set Pe",
                              "mlccactl describe a.xml --unset Pe", "mlccactl mode a",
                              "mlccactl check " + folder});
  EXPECT_EQ(offered[0], (Words{"sarif"}));
  EXPECT_EQ(offered[1], (Words{"raw", "j1939"}));
  EXPECT_EQ(offered[2], (Words{"dbc", "can-gw", "em_canid", "wireshark"}));
  // What a shell puts behind a word is no part of it for zsh.
  EXPECT_TRUE(offered[3] == Words{"Period="} || offered[3] == Words{"Period"});
  EXPECT_EQ(offered[4], (Words{"Period"}));
  EXPECT_EQ(offered[5], (Words{"audit"}));
  const auto is_offered = [&](const std::string& file) {
    return offered[6].contains(file) || offered[6].contains(folder + file);
  };
  EXPECT_TRUE(is_offered("system.xml"));
  EXPECT_FALSE(is_offered("demo")) << "it is no description";
}

/// The forms of files that import knows, as its help has them.
Words forms_of_import() {
  const auto help = test::run_mlccactl({"import", "--help"}).out;
  const std::string before = "--format FORM:{";
  const auto from = help.find(before);
  if (from == std::string::npos) return {};
  auto list = help.substr(from + before.size());
  list.resize(list.find('}'));
  std::ranges::replace(list, ',', ' ');
  return words_of(list);
}

TEST(DocumentationTest, CompletionOffersEveryFormOfImport) {
  EXPECT_EQ(completions("mlccactl import --format \"\"", "/nonexistent"), forms_of_import());
}

TEST_P(ShellTest, OffersEveryFormOfImportAndItsFiles) {
  const std::string folder = ::testing::TempDir() + "mlcca-forms-" + GetParam() + "/";
  std::filesystem::create_directory(folder);
  for (const char* name : {"a.dbc", "a.EDS", "a.yaml", "a.json", "a.txt", "a.xml", "a.png"})
    std::ofstream(folder + name) << '\n';
  const auto offered =
      offered_by(GetParam(), {"mlccactl import --format ", "mlccactl import " + folder});
  std::filesystem::remove_all(folder);
  EXPECT_EQ(offered[0], forms_of_import());
  ASSERT_GT(offered[0].size(), 5U);
  for (const char* name : {"a.dbc", "a.EDS", "a.yaml", "a.json", "a.txt", "a.xml"})
    EXPECT_TRUE(offered[1].contains(name) || offered[1].contains(folder + name)) << name;
  EXPECT_FALSE(offered[1].contains("a.png") || offered[1].contains(folder + "a.png"));
}

TEST_P(ShellTest, AsksTheDaemonForNames) {
  test::Server server([](const control::Request& request) {
    if (std::holds_alternative<control::NetworksRequest>(request.body))
      return test::Server::Answer{{{0, test::full_networks()}}};
    return test::Server::Answer{{{0, control::Channels{{test::refused_channel()}}}}};
  });
  const auto offered =
      offered_by(GetParam(), {"mlccactl explain em", "mlccactl query a --from "}, server.path());
  EXPECT_EQ(offered[0], (Words{"emergency-switch"}));
  EXPECT_EQ(offered[1], (Words{"robot-can", "mesh", "bridge", "second-bridge"}));
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
  EXPECT_EQ(completions("mlccactl import a.dbc --format d", "/nonexistent"),
            (Words{"dbc", "dds-xml"}));
  EXPECT_EQ(completions("mlccactl import a.dbc --profile \"\"", "/nonexistent"),
            (Words{"raw", "j1939"}));
}

TEST(DocumentationTest, CompletionOffersWhatLearnTakes) {
  const auto folder =
      (mlcca::testing::source_tree() / "examples/volksbot/").lexically_normal().string();
  const auto recordings = completions("mlccactl learn " + folder, "/nonexistent");
  EXPECT_TRUE(recordings.contains(folder + "system.xml")) << "a recording can have any name";
  EXPECT_TRUE(recordings.contains(folder + "demo"));
  const auto described = completions("mlccactl learn a.log --merge " + folder, "/nonexistent");
  EXPECT_TRUE(described.contains(folder + "system.xml"));
  EXPECT_FALSE(described.contains(folder + "demo")) << "it is no description";
  EXPECT_FALSE(completions("mlccactl learn --profile \"\"", "/nonexistent").contains("raw"));
  // As bash cuts the words can0= and can0=j.
  EXPECT_EQ(completions("mlccactl learn --profile can0 =", "/nonexistent"),
            (Words{"raw", "famouso", "j1939", "cyphal", "canopen"}));
  EXPECT_EQ(completions("mlccactl learn --profile can0 = j", "/nonexistent"), (Words{"j1939"}));
}

/// Somebody else may have given an interface its name.
TEST(DocumentationTest, CompletionDoesNotRunWhatANameContains) {
  const auto offered = [](const std::string& list, const std::string& words) {
    const std::string script =
        ". " + (mlcca::testing::source_tree() / "tools/completion/mlccactl.bash").string() + "; " +
        list + "() { printf '%s\\n' 'a$(echo b)' 'a*'; }; COMP_WORDS=(" + words +
        "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _mlccactl; printf '%s\\n' \"${COMPREPLY[@]}\"";
    return output_of("bash -c " + quoted(script), "/nonexistent");
  };
  const std::string both = "a\\$\\(echo\\ b\\)\na\\*\n";
  EXPECT_EQ(offered("_mlccactl_can", "mlccactl doctor --can a"), both);
  EXPECT_EQ(offered("_mlccactl_places", "mlccactl query --from a"), both);
  EXPECT_EQ(offered("_mlccactl_places", "mlccactl reservations a"), both);
  EXPECT_EQ(offered("_mlccactl_gates", "mlccactl gate a"), both);
  EXPECT_EQ(offered("_mlccactl_channels", "mlccactl explain a"), both);
  EXPECT_EQ(offered("_mlccactl_learnable", "mlccactl learn --bitrate a"),
            "a\\$\\(echo\\ b\\)=\na\\*=\n");
  EXPECT_TRUE(offered("_mlccactl_learnable", "mlccactl learn a").contains(both));
}

TEST_P(ShellTest, OffersWhatLearnTakes) {
  const auto offered =
      offered_by(GetParam(), {"mlccactl learn --profile can0=", "mlccactl learn --profile=can0=",
                              "mlccactl learn a.log --profile can0=j",
                              "mlccactl learn --bitrate can0=", "mlccactl learn --profile "});
  const auto has_profile = [](const Words& words, const std::string& profile) {
    // fish offers whole words, zsh what stands behind the equals sign.
    return words.contains(profile) || words.contains("can0=" + profile) ||
           words.contains("--profile=can0=" + profile);
  };
  for (const char* profile : {"raw", "famouso", "j1939", "cyphal", "canopen"})
    for (const std::size_t line : {0, 1})
      EXPECT_TRUE(has_profile(offered[line], profile)) << profile << " " << line;
  EXPECT_TRUE(has_profile(offered[2], "j1939"));
  EXPECT_FALSE(has_profile(offered[2], "raw"));
  EXPECT_FALSE(has_profile(offered[3], "raw"));
  EXPECT_FALSE(has_profile(offered[4], "raw")) << "the interface comes first";
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
