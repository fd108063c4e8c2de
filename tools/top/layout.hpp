// SPDX-License-Identifier: BSD-2-Clause
// Rows as text: lines of a screen of a given size, or of a batch.
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

struct Size {
  std::size_t columns = 80;
  std::size_t lines = 24;
};

/// What the screen says beside its rows.
struct Heading {
  std::string gateway;  ///< "bridge of volksbot"
  std::string state;    ///< "enforce, open"
  bool audit = false;   ///< then what rows call drops was let through
  bool alarming = false;
  std::string problem;   ///< of the daemon, or that there is none; empty: nothing
  std::string time;      ///< of the day
  std::string interval;  ///< between two polls
};
[[nodiscard]] Heading heading_of(const control::Status& status);

// At most six characters each, "-" of what is unknown.
/// "0", "0.25", "12.5", "1250", "12.5k"
[[nodiscard]] std::string short_number(std::optional<double> value);
/// "310us", "12.5ms"
[[nodiscard]] std::string short_time(std::optional<double> seconds);
/// "0%", "<0.1%", "12.5%"
[[nodiscard]] std::string short_share(std::optional<double> share);

/// Lines of a screen that are left for rows: above them stand two lines, one more where there is a
/// problem, and the titles; below them the keys.
[[nodiscard]] std::size_t room_for_rows(const Heading& heading, Size size);

/// Exactly `size.lines` lines, or as many as are needed where that is 0 (a batch), none longer than
/// `size.columns` characters. `rows` are arranged.
[[nodiscard]] std::vector<std::string> screen(const Heading& heading, const std::vector<Row>& rows,
                                              const View& view, Size size, Color color);

}  // namespace mlcca::tools::top
