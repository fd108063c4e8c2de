// SPDX-License-Identifier: BSD-2-Clause
// Descriptions that code is generated from.
#pragma once
#include <string>

namespace mlcca::test {

/// Robot with a switch and motors on one bus, and a lamp on a second one behind a gateway. `lost`
/// is how many events in a row the bus may lose; the motors stand 2.
std::string robot(const std::string& lost = "0");

/// A CAN bus of that bit rate that states nothing more, on which a switch on the bus sends 8 bytes
/// every 50 ms to a lamp there. `more` is of the System.
std::string on_a_bus(const std::string& bitrate = "500000", const std::string& more = "");

/// For such a system: a channel "more", which a publisher p and a subscriber q on the bus may have,
/// every ms.
std::string one_more(bool publisher, bool subscriber);

/// A mesh of two nodes that states nothing of its links, which a file says, and over which events
/// of channel "beat" come every 50 ms.
std::string unknown_mesh();

/// Names that are keywords, macros, alike, or bare subjects; descriptions that try to end a
/// comment; the largest and smallest values; user-defined attributes; several attribute sets.
std::string nasty();

/// A publisher of Jitter `sent`, a network that adds `added` and a subscriber that asks for
/// `asked`, all in ms.
std::string jittery(const std::string& sent, const std::string& added, const std::string& asked);

/// A system whose user-defined attribute, channel, network and component all have that name.
std::string called(const std::string& name);

/// A publisher on a network, one of which states `count` user-defined attributes: the network if
/// `of_network`, else the publisher, which the network provides 16 of.
std::string with_user_attributes(int count, bool of_network);

}  // namespace mlcca::test
