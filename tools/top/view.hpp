// SPDX-License-Identifier: BSD-2-Clause
// The user's view of the rows: selection, order and the effect of keys.
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

/// The name of a field as --sort accepts it: "name", "route", ….
[[nodiscard]] std::string_view name_of(Field field);
[[nodiscard]] std::optional<Field> field_named(std::string_view name);
/// All names: "name, route, …".
[[nodiscard]] std::string field_names();

/// The state of the screen that the user controls.
struct View {
  bool by_network = false;
  Field sort = Field::rate;
  bool reverse = false;  ///< otherwise the largest first, and names from a to z
  std::string filter;    ///< shows rows that contain it in name, place, verdict or subject
  bool paused = false;
  bool help = false;
  bool typing = false;  ///< the user is typing a filter
  std::string typed;
  std::size_t first = 0;  ///< index of the first visible row
  bool quit = false;
  bool operator==(const View&) const = default;
};

/// The view after the keys that were typed; `page` is the number of rows that fit the screen. The
/// bytes of an incomplete key stay in `keys`.
[[nodiscard]] View after(View view, std::string& keys, std::size_t page);

/// The rows that match the filter, in order.
[[nodiscard]] std::vector<Row> arranged(std::vector<Row> rows, const View& view);

}  // namespace mlcca::tools::top
