// SPDX-License-Identifier: BSD-2-Clause
// Reads untrusted YAML, and JSON as a subset of it, into values with their lines.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace mlcca::tools::design {

/// The largest number of values; a value counts once for each alias that names it.
inline constexpr std::size_t kMostYamlValues = 262'144;
inline constexpr std::size_t kMostYamlDepth = 32;

/// A value: a scalar, a list or a map. Values refer to each other by their index in YamlText.
struct YamlValue {
  enum class Kind : std::uint8_t { scalar, list, map };
  struct Entry {
    std::size_t key = 0;  ///< index of a scalar
    std::size_t value = 0;
  };
  Kind kind = Kind::scalar;
  int line = 0;
  std::string text;                ///< of a scalar
  std::vector<std::size_t> items;  ///< of a list
  std::vector<Entry> entries;      ///< of a map, including those that a merge key ("<<") adds
  std::size_t count = 1;           ///< the value and all values below it
  std::size_t depth = 0;           ///< nesting depth of lists and maps
};

/// The values of a text. A value can occur at several places (aliases), but never within itself.
class YamlText {
 public:
  [[nodiscard]] const YamlValue& at(std::size_t index) const { return values_[index]; }
  /// The root values, one for each document.
  [[nodiscard]] const std::vector<std::size_t>& roots() const { return roots_; }
  /// The value of a key; nullptr if `map` is no map or does not have the key.
  [[nodiscard]] const YamlValue* find(const YamlValue& map, std::string_view key) const;

 private:
  friend class YamlReader;
  std::vector<YamlValue> values_;
  std::vector<std::size_t> roots_;
};

/// Parses a text; `file` is its name in errors. Empty documents are left out. Keys that are no
/// scalars, duplicate keys and directives are errors.
Result<YamlText> read_yaml(std::string_view text, const std::string& file);

/// An integer, decimal or hexadecimal behind 0x; nullopt for any other text.
std::optional<std::uint64_t> whole_number(std::string_view text);

}  // namespace mlcca::tools::design
