// SPDX-License-Identifier: BSD-2-Clause
// Limits of what a source may report. docs/reference/sources.md lists them, and those of each
// parser.
#pragma once
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>

#include "core/mesh/sample.hpp"

namespace mlcca::core::mesh {

inline constexpr std::size_t kMaxFacts = 8192;   ///< links, and as many next hops, of one source
inline constexpr std::size_t kMaxAddress = 64;   ///< bytes of a MAC or IP address, or a name
inline constexpr std::size_t kMaxProblem = 512;  ///< bytes
inline constexpr Value kMaxRate = 1'000'000'000'000;      ///< bit/s
inline constexpr std::uint64_t kMaxWeight = 0xffff'ffff;  ///< cost of a link
inline constexpr Value kMaxValidity = 600'000'000'000;    ///< ns: 10 min

/// The addresses by which the description identifies its nodes.
using DescribedNodes = std::set<std::string, std::less<>>;
[[nodiscard]] DescribedNodes described_nodes(const Mesh& mesh);

/// Whether the text has 1 to kMaxAddress visible ASCII characters.
[[nodiscard]] bool is_address(std::string_view text);

/// At most kMaxProblem bytes of the text, with control characters replaced by '?'.
[[nodiscard]] std::string bounded_text(std::string_view text);

/// The snapshot within the bounds above. A number out of range becomes the worst one in range: a
/// rate becomes unknown, a loss total. If there are too many links or next hops, those between
/// described nodes are kept first, then those with one described end. What was removed is reported
/// as a problem. No sample is accepted as taken later than `now`.
[[nodiscard]] Snapshot bounded(Snapshot snapshot, const DescribedNodes& described,
                               std::uint64_t now);

}  // namespace mlcca::core::mesh
