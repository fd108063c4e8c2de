// SPDX-License-Identifier: BSD-2-Clause
// Translates an admit or query request into the terms of the core.
#pragma once
#include <optional>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "core/admission/state.hpp"

namespace mlcca {

/// A request that was understood. Without an admission it concerns ends that exist already.
struct ParsedRequest {
  std::size_t channel = 0;
  std::optional<core::Place> from;  ///< only deliveries from this place; nullopt: from all
  std::optional<core::Place> to;    ///< only deliveries to this place; nullopt: to all
  std::optional<core::Admission> admission;
};

/// Translates a request: names become indices, values that are not stated come from the channel.
/// `from` means the publisher at that place. It means a new publisher if there is none, or if the
/// request describes one (node, priority, user, offered, publisher). The same holds for `to`, with
/// required and subscriber. Errors say what would be correct.
[[nodiscard]] Result<ParsedRequest> understand(const core::State& state,
                                               const control::ChannelRequest& request,
                                               core::AdmissionId id);

/// Whether the request states anything about a new publisher.
[[nodiscard]] bool describes_publisher(const control::ChannelRequest& request);

/// Adds the channel of an unlisted request to the state, if the networks allow it, so that
/// understand() finds it. Does nothing for other requests. The error says what is missing, or what
/// is already used.
[[nodiscard]] Result<void> list(core::State& state, const control::ChannelRequest& request);

/// A name of a request as an error repeats it: at most 64 bytes, without control characters.
[[nodiscard]] std::string echoed(const std::string& name);

/// Finds a channel by name or 0x subject. The error names channels that exist.
[[nodiscard]] Result<std::size_t> channel_named(const core::State& state, const std::string& name);

/// Checks that a key of an admission can be shown and stored.
[[nodiscard]] Result<void> check_key(const std::string& key);
/// The time in ns after which an admission is released unless it is renewed; 0 if it has no lease.
/// An admission that a connection holds has 10 s if the request states nothing.
[[nodiscard]] std::uint64_t lease_of(const control::Admit& request);

}  // namespace mlcca
