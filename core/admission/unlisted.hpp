// SPDX-License-Identifier: BSD-2-Clause
// Channels that the description does not have, admitted at run time where a network allows it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "core/reserve/parts.hpp"

namespace mlcca::core {

/// Channels of this kind that a gateway has room for at once, whatever its networks allow.
inline constexpr std::size_t kMaxUnlisted = 256;

/// The identifier by which a CAN network carries a channel: what its profile calls it.
struct UnlistedBinding {
  std::size_t network = 0;
  std::uint32_t id = 0;
  bool extended = false;  ///< of 29 bits; counts for profile raw, the others have one form
  bool operator==(const UnlistedBinding&) const = default;
};

/// A channel of a client that knows the subject but has no description of it.
struct UnlistedChannel {
  Subject subject = 0;
  std::vector<std::size_t> networks;  ///< where it begins and ends; each is asked
  std::vector<UnlistedBinding> bindings;
};

/// So many channels are to be kept free for them in all: what the networks allow, and no more than
/// kMaxUnlisted.
[[nodiscard]] std::size_t unlisted_room(const System& system);

/// What forbids it: a network whose policy does not have the subject, or an identifier that is not
/// right or is taken. `system` has sorted bindings; those of `channel` itself do not count.
[[nodiscard]] Result<void> check_unlisted(const System& system, std::size_t channel,
                                          const UnlistedChannel& wanted);

/// The same for identifiers that other gateways have reserved, by network.
[[nodiscard]] Result<void> check_foreign(const System& system,
                                         const std::vector<cluster::Foreign>& foreign,
                                         const UnlistedChannel& wanted);

/// Puts it among the bindings of the network, which stay sorted.
void bind(Network& network, std::size_t channel, const UnlistedBinding& wanted);

}  // namespace mlcca::core
