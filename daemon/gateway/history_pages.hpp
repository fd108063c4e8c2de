// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstddef>
#include <utility>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "daemon/store/history.hpp"

namespace mlcca {

/// The contents of the history, the newest rows first, one page at a time. Rows that are written
/// meanwhile are newer than those that follow.
class HistoryPages {
 public:
  static constexpr std::size_t kPage = 128;  ///< rows

  HistoryPages(store::History& history, store::HistoryFilter filter)
      : history_(history), filter_(std::move(filter)), left_(filter_.limit) {}

  Result<control::History> next();
  [[nodiscard]] bool more() const { return left_ != 0; }

 private:
  store::History& history_;
  store::HistoryFilter filter_;
  std::size_t left_;
  /// The number of rows already given that have the time at which the next page begins.
  std::size_t again_ = 0;
};

}  // namespace mlcca
