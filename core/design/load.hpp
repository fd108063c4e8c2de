// SPDX-License-Identifier: BSD-2-Clause
// What is granted takes of each network, when everything is decided.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/admission/world.hpp"
#include "core/reserve/ledger.hpp"

namespace mlcca::core {

/// What all fit channels together take of the time of a domain of a mesh.
struct DomainLoad {
  std::string name;
  std::uint64_t time_ppm = 0;  ///< 1e-6, rounded up
};

/// What all fit channels together need of a network.
struct NetworkLoad {
  Value reserved = 0;  ///< payload bytes/s
  /// 1e-6 of the time of a bus, or of the fullest domain of a mesh, where that is computed.
  std::optional<std::uint64_t> time_ppm{};
  std::vector<DomainLoad> domains{};  ///< of a mesh: those that something is taken of
};

[[nodiscard]] NetworkLoad load_of(const Ledger& ledger, const World& world, std::size_t network);

}  // namespace mlcca::core
