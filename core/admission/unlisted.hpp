// SPDX-License-Identifier: BSD-2-Clause
// Unlisted channels: those that are not described, but admitted at run time where a network allows
// it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "core/reserve/parts.hpp"

namespace mlcca::core {

/// The most unlisted channels of one gateway at the same time, whatever its networks allow.
inline constexpr std::size_t kMaxUnlisted = 256;

/// The identifier of a channel on a CAN network, in terms of the network's profile.
struct UnlistedBinding {
  std::size_t network = 0;
  std::uint32_t id = 0;
  bool extended = false;  ///< 29-bit identifier; used with profile raw only, the others have one
                          ///< form
  bool operator==(const UnlistedBinding&) const = default;
};

/// A channel that a client requests by its subject, without a description of it.
struct UnlistedChannel {
  Subject subject = 0;
  std::vector<std::size_t> networks;  ///< where it begins and ends; each must allow it
  std::vector<UnlistedBinding> bindings;
};

/// The number of unlisted channels to reserve room for: the sum over the networks, at most
/// kMaxUnlisted.
[[nodiscard]] std::size_t unlisted_room(const System& system);

/// Checks a request. Errors name the reason: a network does not allow the subject, or an identifier
/// is invalid or in use. `system` must have sorted bindings; those of `channel` itself are ignored.
[[nodiscard]] Result<void> check_unlisted(const System& system, std::size_t channel,
                                          const UnlistedChannel& wanted);

/// Checks the identifiers of a request against those that other gateways have reserved. `foreign`
/// is indexed by network.
[[nodiscard]] Result<void> check_foreign(const System& system,
                                         const std::vector<cluster::Foreign>& foreign,
                                         const UnlistedChannel& wanted);

/// Inserts the binding into those of the network, which stay sorted.
void bind(Network& network, std::size_t channel, const UnlistedBinding& wanted);

}  // namespace mlcca::core
