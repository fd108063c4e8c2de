// SPDX-License-Identifier: BSD-2-Clause
// Replies of mlccad for a person: text that ends with a newline, or nothing.
#pragma once
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "control/messages.hpp"
#include "tools/table.hpp"

namespace mlcca::tools {

std::string render(const control::Status& status, Color color);
/// One line with the health and its reasons, as monitoring systems show it.
std::string check_line(const control::Health& health);
std::string render(const control::Networks& networks, Color color);
std::string render(const control::Routes& routes, Color color);

/// Of each gate its control traffic, then its channels; and, of those that are among `interfaces`,
/// where they are and what became of frames.
std::string render(const control::Gates& gates, const std::vector<control::Interface>& interfaces,
                   Color color);
inline std::string render(const control::Gates& gates, Color color) {
  return render(gates, {}, color);
}
/// The interface that a gate is on; none where it is not among them.
const control::Interface* interface_of(const control::Gate& gate,
                                       const std::vector<control::Interface>& interfaces);

/// All resources, then who holds what of each.
std::string render(const control::Transfers& transfers, Color color);
std::string render(const control::Subscriptions& subscriptions, Color color);
std::string render(const control::Presence& presence, Color color);
std::string render(const control::Reservations& reservations, Color color);

/// The losers first, then a line that counts.
std::string render(const control::WhatIf& what_if, Color color);
/// Granted now, and then no more.
bool loses(const control::Outlook& outlook);

/// The newest last, where a terminal has its prompt.
std::string render(const control::History& history, Color color);

/// An overview: one line for each delivery.
std::string render(const control::Channels& channels, Color color);

/// Each delivery with its verdict, a line for each attribute, the route, and, `in_full`, its
/// importance and the frames that passed and were dropped.
std::string explain(const control::Channels& channels, Color color, bool in_full);

/// What of a channel would stop if it were withdrawn, as `channels` explain it now.
std::string what_stops(const control::Channels& channels, std::string_view name, Color color);

/// How the gateway stands in its cluster; who is there; what they have reserved.
std::string render(const control::Cluster& cluster, Color color);
std::string render(const control::ClusterMembers& members, Color color);
std::string render(const control::ClusterReservations& reservations, Color color);
/// What closes where the gateway is drained.
std::string what_closes(const control::Cluster& cluster, bool until_restart, Color color);

/// What the holder of a lease must know.
std::string lease_note(const control::Admit& request, const std::set<std::uint64_t>& admissions);

std::string render(const control::Done& done, Color color);
std::string render(const control::Rollout& rollout, Color color);

/// One line.
std::string render(const control::Event& event, Color color);

/// "mlccactl: " and the message, then a line for each detail.
std::string render(const control::Error& error, Color color);

}  // namespace mlcca::tools
