// SPDX-License-Identifier: BSD-2-Clause
// Extended regular expressions of the C library; '.' does not match a line's end.
#pragma once
#include <gtest/gtest.h>
#include <regex.h>

#include <array>
#include <string>
#include <vector>

namespace mlcca::description {

class Pattern {
 public:
  explicit Pattern(const std::string& text) {
    const int error = regcomp(&compiled_, text.c_str(), REG_EXTENDED | REG_NEWLINE);
    EXPECT_EQ(error, 0) << "not a regular expression: " << text;
  }
  ~Pattern() { regfree(&compiled_); }
  Pattern(const Pattern&) = delete;
  Pattern(Pattern&&) = delete;
  Pattern& operator=(const Pattern&) = delete;
  Pattern& operator=(Pattern&&) = delete;

  [[nodiscard]] bool matches_whole(const std::string& text) const {
    std::array<regmatch_t, 1> match{};
    return regexec(&compiled_, text.c_str(), 1, match.data(), 0) == 0 && match[0].rm_so == 0 &&
           static_cast<std::size_t>(match[0].rm_eo) == text.size();
  }

  /// The groups of each match, one after the other.
  [[nodiscard]] std::vector<std::array<std::string, 3>> find_all(const std::string& text) const {
    std::vector<std::array<std::string, 3>> out;
    std::array<regmatch_t, 4> match{};
    const char* at = text.c_str();
    while (regexec(&compiled_, at, match.size(), match.data(), 0) == 0) {
      auto& groups = out.emplace_back();
      for (std::size_t i = 0; i < groups.size(); ++i)
        if (match[i + 1].rm_so >= 0)
          groups[i].assign(at + match[i + 1].rm_so, at + match[i + 1].rm_eo);
      if (match[0].rm_eo == 0) break;
      at += match[0].rm_eo;
    }
    return out;
  }

 private:
  regex_t compiled_{};
};

}  // namespace mlcca::description
