// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/import/eds_read.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/number.hpp"
#include "tools/design/import/text.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::size_t kMostObjects = 100'000;
constexpr std::size_t kMostLine = 4'096;
constexpr std::uint32_t kMostIndex = 0xffff;

std::string in_small(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

/// The value without a comment. CiA 306 allows comments only in lines of their own, but files have
/// them behind values, too.
std::string_view without_comment(std::string_view value) {
  return without_blanks(value.substr(0, value.find(';')));
}

/// Parses "0x1f", "037" (octal by CiA 306) or "31".
std::optional<std::uint32_t> constant(std::string_view text) {
  constexpr int octal = 8;
  if (text.starts_with("0x") || text.starts_with("0X"))
    return number_in<std::uint32_t>(text.substr(2), kHexadecimalBase);
  if (text.size() > 1 && text.front() == '0') return number_in<std::uint32_t>(text, octal);
  return number_in<std::uint32_t>(text);
}

class EdsReader {
 public:
  EdsReader(std::string_view text, const std::string& file) : rest_(text), file_(file) {}

  Result<EdsFile> read() {
    bool any = false;
    while (!rest_.empty()) {
      ++line_;
      const auto end = std::min(rest_.find('\n'), rest_.size());
      const auto line = without_blanks(rest_.substr(0, end));
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      if (line.empty() || line.front() == ';' || line.front() == '#') continue;
      if (auto done = take(line); !done) return std::unexpected(done.error());
      any = any || line.front() == '[';
    }
    if (!any)
      return fail(fmt::format("{}: there is no section in it, such as [DeviceInfo]", file_));
    return std::move(out_);
  }

 private:
  [[nodiscard]] std::unexpected<Error> wrong(std::string_view what) const {
    return fail(fmt::format("{}:{}: {}", file_, line_, what));
  }

  Result<void> take(std::string_view line) {
    if (line.size() > kMostLine) return wrong("a line has at most 4096 bytes");
    if (line.front() == '[') {
      if (line.back() != ']') return wrong("a section ends with ']'");
      section_ = in_small(without_blanks(line.substr(1, line.size() - 2)));
      values_of_ = index_of_values(section_);
      object_ = object_of(section_);
      return {};
    }
    const auto equals = line.find('=');
    if (equals == std::string_view::npos)
      return wrong("must be [SECTION], NAME=VALUE or a comment behind ';'");
    const auto name = in_small(without_blanks(line.substr(0, equals)));
    const auto value = without_blanks(line.substr(equals + 1));
    if (values_of_) return compact_value(name, without_comment(value));
    if (object_) return entry(name, without_comment(value));
    if (section_ == "deviceinfo" && name == "productname") out_.product = value;
    if (section_ == "devicecomissioning" || section_ == "devicecommissioning") {
      if (name == "nodename") out_.node_name = value;
      if (name == "nodeid") out_.node = constant(without_comment(value));
      if (name == "baudrate") out_.kilobits = constant(without_comment(value));
    }
    return {};
  }

  /// The index of an object whose values are in a section such as "1800Value": CiA 306 allows that
  /// for objects with CompactSubObj, by sub-index.
  static std::optional<std::uint32_t> index_of_values(std::string_view section) {
    constexpr std::string_view end = "value";
    if (!section.ends_with(end)) return std::nullopt;
    section.remove_suffix(end.size());
    const auto index = number_in<std::uint32_t>(section, kHexadecimalBase);
    return index && *index <= kMostIndex ? index : std::nullopt;
  }

  Result<void> compact_value(std::string_view name, std::string_view value) {
    constexpr std::uint32_t most = 254;
    const auto sub = constant(name);
    if (!sub || *sub == 0 || *sub > most || value.empty()) return {};
    return put({*values_of_, *sub}, value, true);
  }

  Result<void> entry(std::string_view name, std::string_view value) {
    if (name == "compactsubobj" && object_->second == 0) return put(*object_, value, true);
    if ((name != "defaultvalue" && name != "parametervalue") || value.empty()) return {};
    // ParameterValue precedes DefaultValue.
    return put(*object_, value, name == "parametervalue");
  }

  Result<void> put(const std::pair<std::uint32_t, std::uint32_t>& object, std::string_view value,
                   bool replaces) {
    if (out_.objects.size() >= kMostObjects && !out_.objects.contains(object))
      return wrong(fmt::format("there are more than {} objects", kMostObjects));
    auto& there = out_.objects[object];
    if (there.line == 0 || replaces) there = {line_, std::string(value)};
    return {};
  }

  /// The index and sub-index in the name of a section: "1800", "1800sub1".
  static std::optional<std::pair<std::uint32_t, std::uint32_t>> object_of(
      std::string_view section) {
    auto rest = section;
    const auto index = take_number<std::uint32_t>(rest, kHexadecimalBase);
    if (!index || *index > kMostIndex) return std::nullopt;
    if (rest.empty()) return std::pair(*index, 0U);
    if (!rest.starts_with("sub")) return std::nullopt;
    const auto sub = number_in<std::uint32_t>(rest.substr(3), kHexadecimalBase);
    if (!sub) return std::nullopt;
    return std::pair(*index, *sub);
  }

  std::string_view rest_;
  const std::string& file_;
  int line_ = 0;
  std::string section_;
  std::optional<std::pair<std::uint32_t, std::uint32_t>> object_;
  std::optional<std::uint32_t> values_of_;  ///< index of the object in whose section of values the
                                            ///< reader is
  EdsFile out_;
};

}  // namespace

std::optional<std::uint32_t> EdsFile::number(std::uint32_t index, std::uint32_t sub,
                                             unsigned of_node) const {
  const auto found = objects.find({index, sub});
  if (found == objects.end()) return std::nullopt;
  std::string_view rest = found->second.value;
  std::uint32_t sum = 0;
  for (;;) {
    const auto end = std::min(rest.find('+'), rest.size());
    const auto part = without_blanks(rest.substr(0, end));
    const auto value =
        in_small(part) == "$nodeid" ? std::optional<std::uint32_t>(of_node) : constant(part);
    if (!value) return std::nullopt;
    sum += *value;
    if (end == rest.size()) return sum;
    rest.remove_prefix(end + 1);
  }
}

Result<EdsFile> read_eds(std::string_view text, const std::string& file) {
  return EdsReader(text, file).read();
}

}  // namespace mlcca::tools::design
