// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <string>
#include <utility>

namespace mlcca {

/// What is wrong for as long as it lasts. It is reported when it begins and when it becomes another
/// one, not again at each check.
class Problem {
 public:
  /// Takes what a check has found; an empty text means that the problem is over. True: that is to
  /// be reported.
  [[nodiscard]] bool is_new(std::string found) {
    const bool differs = found != text_;
    text_ = std::move(found);
    return differs && lasts();
  }
  /// As whole sentences or clauses; empty when there is none.
  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] bool lasts() const { return !text_.empty(); }

 private:
  std::string text_;
};

}  // namespace mlcca
