// SPDX-License-Identifier: BSD-2-Clause
// Reports a lasting problem once, and not at each check that finds it.
#pragma once
#include <string>
#include <utility>

namespace mlcca {

/// A condition that lasts and has a description. It decides when the condition is reported:
/// when it begins and when its description changes, not at each check.
class Problem {
 public:
  /// Takes the result of a check; an empty text means that the condition is over. Returns true if
  /// it is to be reported.
  [[nodiscard]] bool is_new(std::string found) {
    const bool differs = found != text_;
    text_ = std::move(found);
    return differs && lasts();
  }
  /// The description in sentences or clauses; empty when there is no problem.
  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] bool lasts() const { return !text_.empty(); }

 private:
  std::string text_;
};

}  // namespace mlcca
