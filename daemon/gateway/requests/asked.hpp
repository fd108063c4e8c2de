// SPDX-License-Identifier: BSD-2-Clause
// What a client asks for, in the terms of the core: names become indices, gaps are filled from the
// channel, and nonsense is refused with what would be right.
#pragma once
#include <optional>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "core/admission/state.hpp"

namespace mlcca {

/// A request that was understood. Without an admission it concerns ends that are known already.
struct Asked {
  std::size_t channel = 0;
  std::optional<core::Place> from;  ///< only deliveries from there
  std::optional<core::Place> to;    ///< only deliveries to there
  std::optional<core::Admission> admission;
};

/// `from` means the publisher that is there; a new one where there is none or where the request
/// describes one (node, priority, user, offered, publisher). Likewise `to` with required and
/// subscriber.
[[nodiscard]] Result<Asked> understand(const core::State& state,
                                       const control::ChannelRequest& request,
                                       core::AdmissionId id);

/// It says something of a new publisher.
[[nodiscard]] bool describes_publisher(const control::ChannelRequest& request);

/// Gives a channel that is not described a place in the state, where the request is about one and
/// networks allow it: then it can be understood. Nothing of other requests. The error says what is
/// missing, or taken.
[[nodiscard]] Result<void> list(core::State& state, const control::ChannelRequest& request);

/// Channel by name or 0x subject; the error names what is known.
[[nodiscard]] Result<std::size_t> channel_named(const core::State& state, const std::string& name);

/// Whether a key can be shown and stored.
[[nodiscard]] Result<void> check_key(const std::string& key);
/// ns that an admission lives without being renewed; 0: until it is released. One that a connection
/// holds lives 10 s longer than that if it says nothing else.
[[nodiscard]] std::uint64_t lease_of(const control::Admit& request);

}  // namespace mlcca
