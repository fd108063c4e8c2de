// SPDX-License-Identifier: BSD-2-Clause
// Which networks gateways share, from one description to the next.
#pragma once
#include <cstddef>
#include <string>

#include "core/model/system.hpp"

namespace mlcca::core::cluster {

/// A gateway holds back on the networks that its description shares with others. One that others
/// were on by `before`, and are not any more by `after`, it would use at once, while a gateway that
/// does not know `after` yet still sends there. Why it may not; empty: there is no such network.
/// The numbers are those of the same gateway in both.
[[nodiscard]] std::string no_longer_shared(const System& before, std::size_t self_before,
                                           const System& after, std::size_t self_after);

}  // namespace mlcca::core::cluster
