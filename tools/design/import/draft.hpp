// SPDX-License-Identifier: BSD-2-Clause
// Makes a description of imported networks.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "tools/design/import/network.hpp"

namespace mlcca::tools::design {

/// What the command line states about the description.
struct DraftOptions {
  std::string system;                   ///< name of the system
  std::string gateway;                  ///< name of the gateway; empty: there is none
  std::vector<std::string> interfaces;  ///< interfaces of the gateway, one for each network
};

/// The subject of a message: a hash of its network and identifier, so that another import gives the
/// same one. Never 0.
std::uint64_t subject_of(std::string_view network, const ImportedMessage& message);

/// A valid name that resembles `text`: other characters become '-', it begins with a letter, and it
/// has at most 63 characters.
std::string name_from(std::string_view text);

/// The XML of the description. If two channels or nodes have the same name, the network's name or a
/// number is appended, and the lacks of the network list that.
std::string draft_of(std::vector<ImportedNetwork>& networks, const DraftOptions& options);

}  // namespace mlcca::tools::design
