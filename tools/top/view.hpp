// SPDX-License-Identifier: BSD-2-Clause
// How the user wants to see the rows: which, in which order; and what the keys do.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/top/sample.hpp"

namespace mlcca::tools::top {

enum class Field : std::uint8_t { name, place, verdict, rate, jitter, loss, drops, reserved, used };
inline constexpr std::size_t kFields = 9;

/// "name", "way", …: as --sort takes it; `by_network` changes nothing.
[[nodiscard]] std::string_view name_of(Field field);
[[nodiscard]] std::optional<Field> field_named(std::string_view name);
/// "name, way, …"
[[nodiscard]] std::string field_names();

struct View {
  bool by_network = false;
  Field sort = Field::rate;
  bool reverse = false;  ///< else the largest first, and names from a to z
  std::string filter;    ///< rows that contain it in name, place, verdict or subject
  bool paused = false;
  bool help = false;
  bool typing = false;  ///< a filter
  std::string typed;
  std::size_t first = 0;  ///< row at the top
  bool quit = false;
  bool operator==(const View&) const = default;
};

/// What was typed changes the view; `page`: rows that fit the screen. Octets of a key that has come
/// in part are left in `keys`.
[[nodiscard]] View after(View view, std::string& keys, std::size_t page);

/// Those that fit the filter, in order.
[[nodiscard]] std::vector<Row> arranged(std::vector<Row> rows, const View& view);

}  // namespace mlcca::tools::top
