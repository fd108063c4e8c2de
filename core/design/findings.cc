// SPDX-License-Identifier: BSD-2-Clause
#include "core/design/findings.hpp"

#include <algorithm>
#include <array>

namespace mlcca::core {
namespace {

/// The name of a row with hyphens, as it is printed.
template <std::size_t kSize>
constexpr std::array<char, kSize> hyphenated(const char (&name)[kSize]) {
  std::array<char, kSize> out{};
  std::ranges::transform(name, out.begin(), [](char c) { return c == '_' ? '-' : c; });
  return out;
}
#define FINDING(number, name, severity, title, advice) \
  constexpr auto kNameOf_##name = hyphenated(#name);
#include "core/design/finding_rows.inc"

constexpr auto kTable = std::to_array<FindingInfo>({
#define FINDING(number, name, severity, title, advice) \
  {FindingId::name, Severity::severity, kNameOf_##name.data(), title, advice},
#include "core/design/finding_rows.inc"
});

constexpr bool is_dense() {
  for (std::size_t i = 0; i < kTable.size(); ++i)
    if (static_cast<std::size_t>(kTable[i].id) != i + 1) return false;
  return true;
}
static_assert(is_dense());

}  // namespace

std::span<const FindingInfo> finding_table() { return kTable; }

const FindingInfo& info(FindingId id) { return kTable[static_cast<std::size_t>(id) - 1]; }

std::string code_of(FindingId id) {
  auto digits = std::to_string(static_cast<unsigned>(id));
  return "MLCCA" + std::string(3 - std::min<std::size_t>(3, digits.size()), '0') + digits;
}

}  // namespace mlcca::core
