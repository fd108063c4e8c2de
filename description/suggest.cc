// SPDX-License-Identifier: BSD-2-Clause
// Computes the edit distance with swapped neighbours (optimal string alignment) of short names.
#include "description/suggest.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace mlcca::description {
namespace {

constexpr std::size_t kLongest = 63;
constexpr std::size_t kMostCompared = 4096;
constexpr std::size_t kMostNamed = 9;

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

std::size_t distance(std::string_view a, std::string_view b) {
  using Row = std::array<std::size_t, kLongest + 1>;
  Row before{};
  Row above{};
  Row row{};
  for (std::size_t j = 0; j <= b.size(); ++j) above[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = lower(a[i - 1]) == lower(b[j - 1]);
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (same ? 0U : 1U)});
      const bool swapped = i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) &&
                           lower(a[i - 2]) == lower(b[j - 1]);
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    before = std::exchange(above, row);
  }
  return above[b.size()];
}

}  // namespace

std::string_view closest(std::string_view name, std::span<const std::string_view> known) {
  if (name.size() > kLongest) return {};
  std::size_t best = std::clamp<std::size_t>(name.size() / 3, 1, 2) + 1;
  std::string_view found;
  for (const auto candidate : known.first(std::min(known.size(), kMostCompared))) {
    if (candidate.size() > kLongest) continue;
    const auto [shorter, longer] = std::minmax({candidate.size(), name.size()});
    if (longer - shorter >= best) continue;
    if (const auto d = distance(name, candidate); d < best) {
      best = d;
      found = candidate;
    }
  }
  return found;
}

std::string known_names(std::string_view name, std::span<const std::string_view> known) {
  if (known.empty()) return "none is described";
  std::string out;
  if (const auto close = closest(name, known); !close.empty())
    out = fmt::format("did you mean {}? ", close);
  const auto named = known.first(std::min(known.size(), kMostNamed));
  out += fmt::format("{} {}", out.empty() ? "known:" : "Known:", fmt::join(named, ", "));
  if (known.size() > named.size()) out += fmt::format(" and {} more", known.size() - named.size());
  return out;
}

}  // namespace mlcca::description
