// SPDX-License-Identifier: BSD-2-Clause
// YAML, and JSON, which is a part of it: an untrusted text as values with their lines.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace mlcca::tools::design {

/// Values of a text, each as often as aliases name it.
inline constexpr std::size_t kMostYamlValues = 262'144;
inline constexpr std::size_t kMostYamlDepth = 32;

struct YamlValue {
  enum class Kind : std::uint8_t { scalar, list, map };
  struct Entry {
    std::size_t key = 0;  ///< a scalar
    std::size_t value = 0;
  };
  Kind kind = Kind::scalar;
  int line = 0;
  std::string text;                ///< of a scalar
  std::vector<std::size_t> items;  ///< of a list
  std::vector<Entry> entries;      ///< of a map, with those that "<<" names
  std::size_t count = 1;           ///< of it and of all values below it
  std::size_t depth = 0;           ///< of lists and maps in each other
};

/// A value may stand in several places (aliases), never in itself.
class YamlText {
 public:
  [[nodiscard]] const YamlValue& at(std::size_t index) const { return values_[index]; }
  /// One for each document.
  [[nodiscard]] const std::vector<std::size_t>& roots() const { return roots_; }
  /// The value of that key; nullptr: `map` is none, or has no such key.
  [[nodiscard]] const YamlValue* find(const YamlValue& map, std::string_view key) const;

 private:
  friend class YamlReader;
  std::vector<YamlValue> values_;
  std::vector<std::size_t> roots_;
};

/// `file` is its name in errors. Empty documents are left out. Refused are keys that are no
/// scalars, keys that a map has twice, and directives.
Result<YamlText> read_yaml(std::string_view text, const std::string& file);

/// A whole number, decimal or behind 0x.
std::optional<std::uint64_t> whole_number(std::string_view text);

}  // namespace mlcca::tools::design
