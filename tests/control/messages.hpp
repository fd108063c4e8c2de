// SPDX-License-Identifier: BSD-2-Clause
// One of each message, every field set and no two alike, so that a mixed-up field shows.
#pragma once
#include <string>
#include <vector>

#include "control/messages.hpp"

namespace mlcca::test {

struct NamedRequest {
  std::string name;
  control::Request request;
};
std::vector<NamedRequest> all_requests();

struct NamedReply {
  std::string name;
  control::Reply reply;
};
std::vector<NamedReply> all_replies();

control::ChannelRequest full_channel_request();

/// The paper's emergency switch behind a bridge that only promises Omission 5: refused.
control::Channel refused_channel();
/// 1001 heart-beats, 50 ms apart, one of them missing in between and three now.
control::Watch full_watch();

/// The same on the robot's own bus: granted.
control::Channel granted_channel();

/// The paper's video over the mesh, with a second set of attributes: switched to it.
control::Channel switched_channel();

control::Status full_status();
control::Networks full_networks();
control::Event full_event();

/// A way over both kinds of medium, and one that is not there.
control::Routes full_routes();
control::Transfers full_transfers();
control::Subscriptions full_subscriptions();
control::Presence full_presence();
/// A gate with a slot of each kind, and one about which nothing is said.
control::Gates full_gates();
/// One resource of each kind; of the network more is promised than it has.
control::Reservations full_reservations();
/// One outlook for each effect, the gain first.
control::WhatIf full_what_if();
control::History full_history();
/// Five findings: a CAN frame, a longer one with 29 bits, a datagram, a refused delivery, frames
/// that cannot be read.
control::Audit full_audit();

/// In a cluster of three, one of them gone, while another description comes into force.
control::Cluster full_cluster();
control::ClusterMembers full_cluster_members();
/// One for each state.
control::ClusterReservations full_cluster_reservations();

}  // namespace mlcca::test
