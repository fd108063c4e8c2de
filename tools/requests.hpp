// SPDX-License-Identifier: BSD-2-Clause
// What verbs send that is more than a name: arguments as typed become messages.
#pragma once
#include <chrono>
#include <cstdint>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "tools/options.hpp"

namespace mlcca::tools {

/// How long what is held outlives its holder, unless --lease says otherwise.
inline constexpr std::chrono::nanoseconds kHoldLease = std::chrono::seconds{10};

// An error says which argument is wrong and what would be right.

Result<control::Query> query(const Arguments& from);
Result<control::Admit> admit(const Arguments& from);
Result<control::AnnounceRequest> announce(const Arguments& from);

/// --link is [NETWORK/]FROM,TO=RATE: names of networks and nodes have neither '/' nor ',' nor '='.
/// RATE 0: the link is gone.
Result<control::WhatIfRequest> what_if(const Arguments& from);

/// Of the read-only parts; of the others only whether the options go with them.
Result<control::ClusterRequest> cluster(const Arguments& from);

/// --when-clean is a span as parse_span() reads it.
Result<control::ModeRequest> mode(const Arguments& from);

/// --since and --until are moments as parse_moment() reads them.
Result<control::HistoryRequest> history(const Arguments& from, std::uint64_t now_unix_ns);

}  // namespace mlcca::tools
