// SPDX-License-Identifier: BSD-2-Clause
// Replies of mlccad as text for a person, which is empty or ends with a newline.
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
/// One line with the health and its reasons, in the form of monitoring plugins.
std::string check_line(const control::Health& health);
std::string render(const control::Networks& networks, Color color);
std::string render(const control::Routes& routes, Color color);

/// Each gate with its control traffic, then its channels. For gates whose interface is among
/// `interfaces`, also where the gate is attached and what became of frames.
std::string render(const control::Gates& gates, const std::vector<control::Interface>& interfaces,
                   Color color);
inline std::string render(const control::Gates& gates, Color color) {
  return render(gates, {}, color);
}
/// The interface that a gate is on; nullptr if it is not among `interfaces`.
const control::Interface* interface_of(const control::Gate& gate,
                                       const std::vector<control::Interface>& interfaces);

std::string render(const control::Transfers& transfers, Color color);
std::string render(const control::Subscriptions& subscriptions, Color color);
std::string render(const control::Presence& presence, Color color);
/// All resources, then the reservations of each.
std::string render(const control::Reservations& reservations, Color color);

/// The deliveries that lose first, then a line with counts.
std::string render(const control::WhatIf& what_if, Color color);
/// Whether a delivery is granted now and would no longer be.
bool loses(const control::Outlook& outlook);

/// The newest entry last, next to the prompt of a terminal.
std::string render(const control::History& history, Color color);

/// An overview with one line for each delivery.
std::string render(const control::Channels& channels, Color color);

/// Each delivery with its verdict, a line for each attribute and its route; `in_full` also its
/// importance and the frames that passed and were dropped.
std::string explain(const control::Channels& channels, Color color, bool in_full);

/// Which deliveries of a channel would stop if it were withdrawn, as `channels` explain it now.
std::string what_stops(const control::Channels& channels, std::string_view name, Color color);

/// The state of the gateway in its cluster; the members; their reservations.
std::string render(const control::Cluster& cluster, Color color);
std::string render(const control::ClusterMembers& members, Color color);
std::string render(const control::ClusterReservations& reservations, Color color);
/// What closes when the gateway is drained.
std::string what_closes(const control::Cluster& cluster, bool until_restart, Color color);

/// What a user who has requested an admission with a lease must know.
std::string lease_note(const control::Admit& request, const std::set<std::uint64_t>& admissions);

std::string render(const control::Done& done, Color color);
std::string render(const control::Rollout& rollout, Color color);

/// One line.
std::string render(const control::Event& event, Color color);

/// "mlccactl: " and the message, then a line for each detail.
std::string render(const control::Error& error, Color color);

}  // namespace mlcca::tools
