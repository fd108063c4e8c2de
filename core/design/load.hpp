// SPDX-License-Identifier: BSD-2-Clause
// The load of each network by what is granted, when everything is decided.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/admission/world.hpp"
#include "core/reserve/ledger.hpp"

namespace mlcca::core {

/// The share of a contention domain that all granted channels take together.
struct DomainLoad {
  std::string name;
  std::uint64_t time_ppm = 0;  ///< in 1e-6, rounded up
};

/// What all granted channels together take of a network.
struct NetworkLoad {
  Value reserved = 0;  ///< payload bytes/s
  /// The share (1e-6) of a bus, or of the fullest domain of a mesh; nullopt if it is not computed.
  std::optional<std::uint64_t> time_ppm{};
  std::vector<DomainLoad> domains{};  ///< for a mesh: the domains with a load
};

/// The load of a network according to the ledger.
[[nodiscard]] NetworkLoad load_of(const Ledger& ledger, const World& world, std::size_t network);

}  // namespace mlcca::core
