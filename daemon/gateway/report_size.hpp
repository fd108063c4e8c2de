// SPDX-License-Identifier: BSD-2-Clause
// Estimates how long a report is. A report that is too long for one turn of the loop is made by a
// child process, or not completely.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/admission/state.hpp"
#include "core/model/verdict.hpp"

namespace mlcca {

/// The most lines that are made at once in the loop. Each takes some microseconds: 1,000 of them
/// take 1 to 5 ms.
inline constexpr std::size_t kMostLines = 1024;
/// The most verdicts of a channel, or publishers and subscribers of it, that are examined in one
/// turn of the loop.
inline constexpr std::size_t kManyEnds = 256;

/// The lines about one delivery: its subscribers, comparisons and hops, as far as they are listed,
/// and the paths through meshes that are evaluated for it.
[[nodiscard]] std::size_t lines_of(const core::State& state, const core::Verdict& verdict);

/// The lines of a report on everything: networks, gateways, nodes and links of meshes, deliveries,
/// and what their publishers hold. Counting stops above `most`.
[[nodiscard]] std::size_t lines_of(const core::State& state, std::size_t most);

/// Reduces `deliveries` to those that can be reported at once: kMostLines together, at least one
/// delivery, refused ones first. Returns how many were removed.
std::uint32_t leave_out(const core::State& state, std::vector<const core::Verdict*>& deliveries);

}  // namespace mlcca
