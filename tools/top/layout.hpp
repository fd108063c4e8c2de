// SPDX-License-Identifier: BSD-2-Clause
// Lays rows out as the lines of a screen of a given size, or of a batch.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/table.hpp"
#include "tools/top/sample.hpp"
#include "tools/top/view.hpp"

namespace mlcca::tools::top {

/// The size of the screen in characters.
struct Size {
  std::size_t columns = 80;
  std::size_t lines = 24;
};

/// The content of the screen above the rows.
struct Heading {
  std::string gateway;  ///< "bridge of volksbot"
  std::string state;    ///< "enforce, open"
  bool audit = false;   ///< then the column of drops shows frames that audit mode passed
  bool alarming = false;
  std::string problem;   ///< of the daemon, or that there is none; empty: no problem
  std::string time;      ///< time of day
  std::string interval;  ///< between two samples
};
[[nodiscard]] Heading heading_of(const control::Status& status);

// Short texts for cells: at most six characters, "-" for an unknown value.
/// "0", "0.25", "12.5", "1250", "12.5k"
[[nodiscard]] std::string short_number(std::optional<double> value);
/// "310us", "12.5ms"
[[nodiscard]] std::string short_time(std::optional<double> seconds);
/// "0%", "<0.1%", "12.5%"
[[nodiscard]] std::string short_share(std::optional<double> share);

/// The lines of a screen that remain for rows, besides two lines of heading, one for a problem if
/// there is one, the titles, and the keys at the bottom.
[[nodiscard]] std::size_t room_for_rows(const Heading& heading, Size size);

/// Exactly `size.lines` lines, or as many as needed if that is 0 (a batch), each of at most
/// `size.columns` characters. `rows` must be in order.
[[nodiscard]] std::vector<std::string> screen(const Heading& heading, const std::vector<Row>& rows,
                                              const View& view, Size size, Color color);

}  // namespace mlcca::tools::top
