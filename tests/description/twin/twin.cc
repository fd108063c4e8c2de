// SPDX-License-Identifier: BSD-2-Clause
#include "tests/description/twin/twin.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string_view>

#include "core/design/findings.hpp"
#include "core/design/inspect.hpp"
#include "core/model/text.hpp"

namespace mlcca::testing {
namespace {

/// The rest of `text` up to `end`, which is taken off with it.
std::string_view cut(std::string_view& text, std::string_view end) {
  const auto at = std::min(text.find(end), text.size());
  const auto part = text.substr(0, at);
  text.remove_prefix(std::min(at + end.size(), text.size()));
  return part;
}

/// The same after `name`, if that comes next.
std::string named(std::string_view& text, std::string_view name, std::string_view end) {
  if (!text.starts_with(name)) return {};
  text.remove_prefix(name.size());
  return std::string(cut(text, end));
}

std::optional<Value> number_of(const std::string& text) {
  Value value = 0;
  if (text == "unbounded") return kUnbounded;
  if (std::from_chars(text.data(), text.data() + text.size(), value).ec != std::errc{})
    return std::nullopt;
  return value;
}

/// Numbers of the twin as the C++ checker writes them for people.
void put_in_words(const core::System& system, Key& key) {
  const auto required = number_of(key.required);
  const auto provided = number_of(key.provided);
  const auto put = [&](const auto& words) {
    if (required) key.required = words(*required);
    if (provided) key.provided = words(*provided);
  };
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const Attribute a = attribute_at(i);
    if (key.attribute != info(a).name) continue;
    put([a](Value value) { return core::format_value(a, value); });
    if (!required || !provided) return;
    const core::BoundWords both = core::format_bound(a, *provided, *required);
    key.required = both.limit;
    key.provided = both.bound;
    return;
  }
  for (const auto& user : system.user_attributes)
    if (key.attribute == user.name)
      put([&user](Value value) { return core::format_user_value(user, value); });
}

/// "50 ns": the number without its unit.
std::string number(std::string_view text) { return std::string(text.substr(0, text.find(' '))); }

/// "error MLCCA021: publisher P, subscriber S, hop H, attribute A: required R ns, provided Q ns"
Key parse(std::string_view line) {
  Key key;
  key.id = named(line, "error ", ": ");
  key.publisher = named(line, "publisher ", ", ");
  const bool whole = line.find(", attribute ") != std::string_view::npos;
  key.subscriber = named(line, "subscriber ", whole ? ", " : ": ");
  key.hop = named(line, "hop ", ", ");
  key.attribute = named(line, "attribute ", ": ");
  key.required = number(named(line, "required ", ", "));
  if (line == "provided without a bound")
    key.provided = "unbounded";
  else if (line.starts_with("provided "))
    key.provided = number(named(line, "provided ", "\n"));
  else if (whole)
    key.provided = std::string(line);
  return key;
}

/// "note MLCCA039: publisher P, attribute Period: …", "note MLCCA040: gateway G, network N: …"
Key parse_note(std::string_view line) {
  Key key;
  key.id = named(line, "note ", ": ");
  key.publisher = named(line, "publisher ", ", ");
  key.subscriber = named(line, "subscriber ", ", ");
  key.attribute = named(line, "attribute ", ": ");
  key.hop = named(line, "gateway ", ", ");
  key.network = named(line, "network ", ": ");
  return key;
}

}  // namespace

std::string to_string(const Key& key) {
  return key.id + " " + key.publisher + " " + key.subscriber + " " + key.hop + " " + key.attribute +
         " (" + key.required + ", " + key.provided + ")";
}

std::string output_of(const std::string& command) {
  FILE* const pipe = popen(command.c_str(), "r");
  std::string out;
  std::array<char, 65536> block{};
  for (std::size_t got = 1; pipe != nullptr && got > 0;) {
    got = std::fread(block.data(), 1, block.size(), pipe);
    out.append(block.data(), got);
  }
  EXPECT_EQ(pipe == nullptr ? -1 : pclose(pipe), 0) << command.substr(0, 200);
  return out;
}

Folder::Folder() {
  std::string name = (std::filesystem::temp_directory_path() / "mlcca-twin-XXXXXX").string();
  EXPECT_NE(mkdtemp(name.data()), nullptr);
  path_ = name;
}

Folder::~Folder() {
  std::error_code ignored;  // a folder that stays is no failure of what was tested
  std::filesystem::remove_all(path_, ignored);
}

std::string Folder::add(const std::string& name, const std::string& text) const {
  auto path = path_ + "/" + name;
  std::ofstream(path) << text;
  return path;
}

namespace {

/// The findings that `output` has for `files` files, one after the other.
std::vector<Keys> parse_output(const std::string& output, std::size_t files) {
  std::istringstream out(output);
  std::vector<Keys> all(1);
  std::size_t lines = 0;
  std::size_t notes = 0;
  for (std::string line; std::getline(out, line);) {
    if (line.starts_with("note: ") || line.starts_with("note MLCCA034: ")) continue;
    if (line.starts_with("note ")) {
      EXPECT_TRUE(all.back().insert(parse_note(line)).second) << "a note stands there twice";
      ++notes;
      continue;
    }
    if (line.starts_with("error ")) {
      all.back().insert(parse(line));
      ++lines;
      continue;
    }
    EXPECT_EQ(line, std::to_string(lines) + " findings");
    EXPECT_EQ(lines + notes, all.back().size()) << "a finding stands there twice";
    lines = notes = 0;
    all.emplace_back();
  }
  all.pop_back();
  EXPECT_EQ(all.size(), files);
  all.resize(files);
  return all;
}

}  // namespace

namespace {

/// Calls `use` with the output for some of the files, and how many they are, until it had all.
template <class Use>
void run_twin(const std::vector<std::string>& files, const Use& use) {
  constexpr std::size_t at_once = 400;  // a command line has a limit
  for (std::size_t first = 0; first < files.size(); first += at_once) {
    const auto last = std::min(first + at_once, files.size());
    std::string command = "xsltproc --xinclude --nonet description/check.xsl";
    for (std::size_t i = first; i < last; ++i) command += " '" + files[i] + "'";
    use(output_of(command), last - first);
  }
}

}  // namespace

std::vector<Keys> twin_findings(const std::vector<std::string>& files) {
  std::vector<Keys> all;
  run_twin(files, [&](const std::string& output, std::size_t count) {
    std::ranges::move(parse_output(output, count), std::back_inserter(all));
  });
  return all;
}

std::vector<std::set<std::string>> twin_left(const std::vector<std::string>& files) {
  std::vector<std::set<std::string>> all;
  run_twin(files, [&](const std::string& output, std::size_t) {
    std::istringstream out(output);
    std::set<std::string> left;
    bool has_rest = false;
    for (std::string line; std::getline(out, line);) {
      if (line.ends_with(" findings")) {
        EXPECT_TRUE(has_rest);
        all.push_back(std::exchange(left, {}));
        has_rest = false;
      }
      if (!line.starts_with("note MLCCA034: ")) continue;
      has_rest |= line.starts_with("note MLCCA034: identifiers, lengths of frames, ");
      auto rest = std::string_view(line).substr(std::string_view("note MLCCA034: ").size());
      const std::string publisher = named(rest, "publisher ", ", ");
      const std::string name =
          named(rest, "subscriber ", rest.find(", hop ") != rest.npos ? ", " : ": ");
      if (!publisher.empty()) left.insert(publisher + " " + name);
    }
  });
  EXPECT_EQ(all.size(), files.size());
  all.resize(files.size());
  return all;
}

namespace {

bool is_note_of_both(core::FindingId id) {
  using enum core::FindingId;
  return id == no_omission || id == long_period || id == managed_in_vain || id == unstarted_sender;
}

/// "the port of gateway G on N is managed": N.
std::string network_in(const std::string& text) {
  const auto at = text.find(" on ") + 4;
  return text.substr(at, text.find(' ', at) - at);
}

}  // namespace

Keys findings_of(core::System system) {
  for (auto& network : system.networks)
    std::ranges::sort(network.bindings, {}, &core::Binding::channel);
  Keys out;
  for (const auto& f : core::inspect(system).findings) {
    const bool is_note = is_note_of_both(f.id);
    if (f.id != core::FindingId::no_publisher && f.id != core::FindingId::traffic_mismatch &&
        f.id != core::FindingId::hop_unfit && !is_note)
      continue;
    Key key;
    key.id = core::code_of(f.id);
    if (f.publisher != core::kNone) key.publisher = system.publishers[f.publisher].name;
    if (f.subscriber != core::kNone) key.subscriber = system.subscribers[f.subscriber].name;
    if (f.has_place) key.hop = core::name_of(system, f.place);
    key.attribute = f.attribute;
    if (is_note) {
      if (f.has_place) key.network = network_in(f.text);
      out.insert(std::move(key));
      continue;
    }
    key.required = f.required;
    key.provided = f.provided;
    out.insert(std::move(key));
  }
  return out;
}

Keys in_words(const core::System& system, const Keys& keys) {
  Keys out;
  for (Key key : keys) {
    put_in_words(system, key);
    out.insert(std::move(key));
  }
  return out;
}

}  // namespace mlcca::testing
