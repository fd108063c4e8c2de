// SPDX-License-Identifier: BSD-2-Clause
// How much there is to say: what is too much for one turn of the loop is said by a child process,
// or not all of it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/admission/state.hpp"
#include "core/model/verdict.hpp"

namespace mlcca {

/// That are said in the loop, at once. Each takes some microseconds: 1,000 of them 1 to 5 ms.
inline constexpr std::size_t kMostLines = 1024;
/// Verdicts of a channel, or its publishers and subscribers: what has more is not examined in one
/// turn of the loop.
inline constexpr std::size_t kManyEnds = 256;

/// Of one delivery: its subscribers, comparisons and hops, as far as they are listed, and the ways
/// through meshes that are evaluated for it.
[[nodiscard]] std::size_t lines_of(const core::State& state, const core::Verdict& verdict);

/// Of everything that a report on all of it may list: networks, gateways, nodes and links of
/// meshes, deliveries, and what their publishers hold. Counted until it is more than `most`.
[[nodiscard]] std::size_t lines_of(const core::State& state, std::size_t most);

/// What is said at once of these deliveries: as many as have kMostLines together, one at least, and
/// what is refused first. The others are taken out of the list. Gives how many they are.
std::uint32_t leave_out(const core::State& state, std::vector<const core::Verdict*>& deliveries);

}  // namespace mlcca
