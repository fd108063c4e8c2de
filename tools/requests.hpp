// SPDX-License-Identifier: BSD-2-Clause
// Requests of verbs with arguments: they convert what was typed into messages.
#pragma once
#include <chrono>
#include <cstdint>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "tools/options.hpp"

namespace mlcca::tools {

/// How long an admission that is held outlives the process that holds it, without --lease.
inline constexpr std::chrono::nanoseconds kHoldLease = std::chrono::seconds{10};

// In each of these an error states which argument is wrong and what would be right.

Result<control::Query> query(const Arguments& from);
Result<control::Admit> admit(const Arguments& from);
Result<control::AnnounceRequest> announce(const Arguments& from);

/// Each --link is [NETWORK/]FROM,TO=RATE; names of networks and nodes contain no '/', ',' or '='.
/// RATE 0 means that the link is gone.
Result<control::WhatIfRequest> what_if(const Arguments& from);

/// The request for a part that only reads. For the other parts it only checks that the options fit.
Result<control::ClusterRequest> cluster(const Arguments& from);

/// --when-clean is a span; see parse_span().
Result<control::ModeRequest> mode(const Arguments& from);

/// --since and --until are moments; see parse_moment().
Result<control::HistoryRequest> history(const Arguments& from, std::uint64_t now_unix_ns);

}  // namespace mlcca::tools
