// SPDX-License-Identifier: BSD-2-Clause
// Shortens repeated problems: a problem that occurs at many places is shown a few times, with the
// number of the others.
#pragma once
#include <algorithm>
#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "core/design/findings.hpp"

namespace mlcca::description {

/// Problems of one kind that are shown.
inline constexpr std::size_t kMostOfAKind = 20;

/// The kind of a problem: its text without quoted names, words with digits, and the hint after the
/// semicolon. All unknown names are one kind.
[[nodiscard]] inline std::string kind_of(core::FindingId id, std::string_view text) {
  std::string out;
  if (id == core::FindingId::unknown_name) return out;
  text = text.substr(0, text.find(';'));
  while (!text.empty()) {
    const bool quoted = text.front() == '\'';
    const auto end = text.find(quoted ? '\'' : ' ', 1);
    const auto word = text.substr(0, end == std::string_view::npos ? end : end + 1);
    text.remove_prefix(word.size());
    const bool varies =
        quoted || std::ranges::any_of(word, [](char c) { return c >= '0' && c <= '9'; });
    out += varies ? std::string_view("* ") : word;
  }
  return out;
}

/// Keeps at most kMostOfAKind problems of each kind and element; the last one states how many were
/// left out. `Mistake` has id, element and text. Problems without an element are all kept.
template <class Mistake>
[[nodiscard]] std::vector<Mistake> shortened(std::vector<Mistake> mistakes) {
  struct Kind {
    std::size_t count = 0;
    std::size_t more = 0;  ///< index in `out` of the one that states the number
  };
  std::map<std::tuple<core::FindingId, std::string, std::string>, Kind> kinds;
  std::vector<Mistake> out;
  for (Mistake& mistake : mistakes) {
    if (!mistake.element.empty()) {
      Kind& kind = kinds[{mistake.id, mistake.element, kind_of(mistake.id, mistake.text)}];
      if (++kind.count > kMostOfAKind) continue;
      kind.more = out.size();
    }
    out.push_back(std::move(mistake));
  }
  for (const auto& [what, kind] : kinds)
    if (kind.count > kMostOfAKind)
      out[kind.more].text += " (and " + std::to_string(kind.count - kMostOfAKind) +
                             " more of this kind, which are not shown)";
  return out;
}

}  // namespace mlcca::description
