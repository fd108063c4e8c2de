// SPDX-License-Identifier: BSD-2-Clause
// What a source may say at most. docs/reference/sources.md lists these bounds and those of each
// parser.
#pragma once
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>

#include "core/mesh/sample.hpp"
#include "daemon/net/sources/source.hpp"

namespace mlcca::net {

inline constexpr std::size_t kMaxFacts = 8192;   ///< links, and as many next hops, of one source
inline constexpr std::size_t kMaxAddress = 64;   ///< bytes: a MAC or IP address, or a name
inline constexpr std::size_t kMaxProblem = 512;  ///< bytes
inline constexpr Value kMaxRate = 1'000'000'000'000;      ///< bit/s
inline constexpr std::uint64_t kMaxWeight = 0xffff'ffff;  ///< cost of a link
inline constexpr Value kMaxValidity = 600'000'000'000;    ///< ns: 10 min

/// The addresses by which the description knows its nodes.
using Described = std::set<std::string, std::less<>>;
[[nodiscard]] Described described_nodes(const core::mesh::Mesh& mesh);

/// 1 to kMaxAddress visible characters of ASCII.
[[nodiscard]] bool is_address(std::string_view text);

/// At most kMaxProblem bytes, whose control characters become '?'.
[[nodiscard]] std::string bounded_text(std::string_view text);

/// The snapshot within the bounds above. A number that is out of range becomes the worst in range:
/// a rate is unknown then, a loss is all. Of too many links or next hops those between described
/// nodes are kept first, then those with one described end. What was left out is said as a problem.
/// `now`: a sample cannot have been taken later.
[[nodiscard]] core::mesh::Snapshot bounded(core::mesh::Snapshot snapshot,
                                           const Described& described, std::uint64_t now);

/// `report` of what is bounded(), at the time of the loop.
[[nodiscard]] LinkSource::Report bounded_report(LinkSource::Report report,
                                                const core::mesh::Mesh& mesh, sd_event* loop);

}  // namespace mlcca::net
