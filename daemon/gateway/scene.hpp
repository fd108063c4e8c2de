// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "base/sha256.hpp"
#include "core/admission/state.hpp"

namespace mlcca {

/// The description in force and its decisions. All parts of a gateway read it; only the controller
/// replaces it.
struct Scene {
  std::unique_ptr<core::State> state;
  std::size_t self = 0;             ///< index of this gateway
  std::uint64_t description = 0;    ///< counts descriptions: indices differ between them
  Sha256::Digest digest = {};       ///< of the description; only in a cluster
  Sha256::Digest file_digest = {};  ///< of the file that the options name, as it was read
  bool unchecked = false;           ///< other gateways may be on any of its networks
  std::string text{};  ///< of the description, until it is kept on disk for other gateways
};

}  // namespace mlcca
