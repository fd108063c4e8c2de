// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstddef>
#include <utility>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "daemon/store/history.hpp"

namespace mlcca {

/// What the history has, the newest first, a page at a time. What comes in meanwhile is newer.
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
  /// Rows of the time at which the next page begins that were given already.
  std::size_t again_ = 0;
};

}  // namespace mlcca
