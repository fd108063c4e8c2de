// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "base/sha256.hpp"
#include "core/admission/state.hpp"

namespace mlcca {

/// What is decided now. The parts of a gateway read it; its controller alone exchanges it.
struct Scene {
  std::unique_ptr<core::State> state;
  std::size_t self = 0;             ///< this gateway
  std::uint64_t description = 0;    ///< counts the states: of another one indices mean other things
  Sha256::Digest digest = {};       ///< of the description, in a cluster
  Sha256::Digest file_digest = {};  ///< of the file that the options name, when it was read
  bool unchecked = false;           ///< others may be on any of its networks
  std::string text{};               ///< of the description, until it is kept for other gateways
};

}  // namespace mlcca
