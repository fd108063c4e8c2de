// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/generate/callbacks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include "base/hash.hpp"
#include "tools/design/generate/names.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::string_view kBegin = "// BEGIN user code: ";
constexpr std::string_view kEnd = "// END user code: ";
constexpr std::string_view kChecksum = "// Checksum of what stands outside of user code: ";
constexpr std::string_view kKept =
    "// Code of handlers that no channel has any more. Nothing is lost: move it, or delete it "
    "with\n"
    "// its markers. A channel that comes back under its name gets it back.\n";
constexpr std::string_view kKeptBegin = "// BEGIN kept code";

/// The code between two markers, with complete lines.
struct Region {
  std::string name;
  std::string code;
};

struct Parsed {
  std::string skeleton;  ///< everything outside of the regions, with the markers, without the line
                         ///< with the checksum
  std::string checksum;
  std::vector<Region> regions;
  std::vector<Region> kept;
};

std::string_view trimmed(std::string_view line) {
  const auto first = line.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return line.substr(first, line.find_last_not_of(" \t\r\n") - first + 1);
}

/// Removes and returns the next line with its newline.
std::string_view take_line(std::string_view& text) {
  const auto end = std::min(text.find('\n'), text.size() - 1) + 1;
  const auto line = text.substr(0, end);
  text.remove_prefix(end);
  return line;
}

std::string checksum_of(std::string_view text) {
  std::uint64_t hash = kHashOfNothing;
  for (const unsigned char c : text)
    if (c != '\r') hash = hash_with(hash, c);
  return fmt::format("{:016x}", hash);
}

/// The code of a region without the `#if 0` that disables it at the end of the file.
std::string uncovered(const std::string& code) {
  constexpr std::string_view on = "#if 0\n";
  constexpr std::string_view off = "#endif\n";
  std::string_view view = code;
  if (view.starts_with(on) && view.ends_with(off)) {
    view.remove_prefix(on.size());
    view.remove_suffix(off.size());
  }
  return std::string(view);
}

/// Parses a file line by line.
class Parser {
 public:
  explicit Parser(std::string_view text) : text_(text) {}

  Result<Parsed> run() {
    while (!text_.empty()) {
      const auto line = next();
      const auto words = trimmed(line);
      kept_ = kept_ || words == kKeptBegin;
      if (words.starts_with(kChecksum)) {
        out_.checksum = words.substr(kChecksum.size());
        continue;
      }
      if (words.starts_with(kEnd))
        return fail(fmt::format("line {}: '{}' has no beginning", number_, words));
      outside(line);
      if (!words.starts_with(kBegin)) continue;
      if (auto done = region(words); !done) return std::unexpected(done.error());
    }
    return std::move(out_);
  }

 private:
  std::string_view next() {
    ++number_;
    return take_line(text_);
  }

  void outside(std::string_view line) {
    if (!kept_) out_.skeleton += line;
  }

  /// Reads a region behind its marker `begin`, with the marker that ends it.
  Result<void> region(std::string_view begin) {
    Region region{.name = std::string(begin.substr(kBegin.size())), .code = {}};
    const auto end = fmt::format("{}{}", kEnd, region.name);
    const int start = number_;
    while (!text_.empty()) {
      const auto line = next();
      if (trimmed(line) == end) {
        outside(line);
        return keep(std::move(region), start);
      }
      if (trimmed(line).starts_with(kBegin))
        return fail(
            fmt::format("line {}: user code begins inside of the one of line {}", number_, start));
      region.code += line;
    }
    return fail(fmt::format("line {}: '{}' has no end", start, begin));
  }

  Result<void> keep(Region region, int line) {
    auto& regions = kept_ ? out_.kept : out_.regions;
    if (!names_.emplace(kept_, region.name).second)
      return fail(fmt::format("line {}: user code {} is there twice", line, region.name));
    if (kept_) region.code = uncovered(region.code);
    regions.push_back(std::move(region));
    return {};
  }

  std::string_view text_;
  int number_ = 0;                                ///< the latest line that was read
  bool kept_ = false;                             ///< within the disabled code at the end
  std::set<std::pair<bool, std::string>> names_;  ///< names of regions, separately for disabled
                                                  ///< ones
  Parsed out_;
};

Result<Parsed> parse(std::string_view text) { return Parser(text).run(); }

class Skeleton {
 public:
  Skeleton(const core::System& system, const Unit& unit, const std::vector<Callback>& callbacks) {
    outside(fmt::format("// {}: write between the markers of user code, nowhere else.\n", kMark));
    outside(fmt::format("// System {}, {} {}.\n", comment_text(system.name), unit.about,
                        comment_text(unit.name)));
    outside(fmt::format("#include \"{}_channels.hpp\"\n\n", unit.stem));
    region("includes", "", "");
    outside(fmt::format("\nnamespace {} {{\nnamespace {} {{\n\n", system_namespace(system),
                        unit.scope));
    region("helpers", "", "");
    for (const auto& callback : callbacks) handler(callback);
    outside(fmt::format("\n}}  // namespace {}\n}}  // namespace {}\n", unit.scope,
                        system_namespace(system)));
  }

  [[nodiscard]] const std::string& text() const { return text_; }
  /// The text outside of the regions, with their markers.
  [[nodiscard]] const std::string& outside() const { return outside_; }

 private:
  void region(const std::string& name, std::string_view indent, const std::string& code) {
    outside(fmt::format("{}{}{}\n", indent, kBegin, name));
    text_ += code;
    outside(fmt::format("{}{}{}\n", indent, kEnd, name));
  }

  void handler(const Callback& callback) {
    const auto name =
        fmt::format("{}::{}", callback.spec, callback.notifies ? "notify" : "exception");
    outside(callback.notifies ? "\n/// An event has arrived.\n"
                              : "\n/// The channel cannot do what it was specified for.\n");
    outside(fmt::format(
        "void {}({}) {{\n", name,
        callback.notifies ? "const uint8_t* event, size_t size" : "ChannelException why"));
    region(name, "  ",
           callback.notifies ? "  static_cast<void>(event);\n  static_cast<void>(size);\n"
                             : "  static_cast<void>(why);\n");
    outside("}\n");
  }

  void outside(std::string_view text) {
    text_ += text;
    outside_ += text;
  }

  std::string text_;
  std::string outside_;
};

/// Whether a region contains only what was generated.
bool is_untouched(const Region& region) {
  std::string_view text = region.code;
  while (!text.empty()) {
    const auto line = trimmed(take_line(text));
    if (!line.empty() && line != "static_cast<void>(event);" &&
        line != "static_cast<void>(size);" && line != "static_cast<void>(why);")
      return false;
  }
  return true;
}

/// Combines regions: code at its place precedes disabled code of the same name, unless it was never
/// changed.
std::vector<Region> merged(std::vector<Region> regions, std::vector<Region> kept) {
  std::map<std::string, std::size_t> at;
  std::vector<bool> gone(regions.size(), false);
  for (std::size_t i = 0; i < regions.size(); ++i) at.emplace(regions[i].name, i);
  for (auto& region : kept) {
    if (const auto same = at.find(region.name);
        same != at.end() && is_untouched(regions[same->second])) {
      gone[same->second] = true;
      at.erase(same);
    }
    while (!at.try_emplace(region.name, regions.size()).second) region.name += " (earlier)";
    regions.push_back(std::move(region));
    gone.push_back(false);
  }
  std::vector<Region> out;
  out.reserve(regions.size());
  for (std::size_t i = 0; i < regions.size(); ++i)
    if (!gone[i]) out.push_back(std::move(regions[i]));
  return out;
}

/// The skeleton with the code of `regions` in it; those that are used are removed from `regions`.
std::string filled(std::string_view skeleton, std::vector<Region>& regions) {
  std::map<std::string, std::size_t, std::less<>> at;
  std::vector<bool> used(regions.size(), false);
  for (std::size_t i = 0; i < regions.size(); ++i) at.emplace(regions[i].name, i);
  std::string out;
  while (!skeleton.empty()) {
    const auto line = take_line(skeleton);
    out += line;
    if (!trimmed(line).starts_with(kBegin)) continue;
    const auto name = trimmed(line).substr(kBegin.size());
    const auto found = at.find(name);
    if (found == at.end()) continue;
    while (!trimmed(skeleton.substr(0, skeleton.find('\n'))).starts_with(kEnd)) take_line(skeleton);
    out += regions[found->second].code;
    used[found->second] = true;
    at.erase(found);
  }
  std::size_t i = 0;
  std::erase_if(regions, [&](const Region&) { return used[i++]; });
  return out;
}

std::string with_kept(std::string text, const std::vector<Region>& kept) {
  if (kept.empty()) return text;
  text += fmt::format("{}\n{}", kKeptBegin, kKept);
  for (const auto& region : kept)
    text +=
        fmt::format("{0}{1}\n#if 0\n{2}#endif\n{3}{1}\n", kBegin, region.name, region.code, kEnd);
  return text;
}

}  // namespace

Result<std::string> callbacks_of(const core::System& system, const Unit& unit,
                                 const std::vector<Callback>& callbacks,
                                 const std::optional<std::string>& old, bool force) {
  const Skeleton fresh(system, unit, callbacks);
  auto parsed = parse(old.value_or(""));
  if (!parsed) return std::unexpected(parsed.error());
  if (old && !force && parsed->checksum != checksum_of(parsed->skeleton))
    return fail(
        "something was changed outside of the user code; move it between the markers, or give it "
        "up with --force");
  auto regions = merged(std::move(parsed->regions), std::move(parsed->kept));
  auto text = filled(fresh.text(), regions);
  std::erase_if(regions, is_untouched);
  const auto checksum = fmt::format("{}{}\n", kChecksum, checksum_of(fresh.outside()));
  const auto second_line = text.find('\n') + 1;
  text.insert(second_line, checksum);
  return with_kept(std::move(text), regions);
}

std::vector<std::string> kept_regions(std::string_view text) {
  std::vector<std::string> out;
  if (const auto parsed = parse(text))
    for (const auto& region : parsed->kept) out.push_back(region.name);
  return out;
}

}  // namespace mlcca::tools::design
