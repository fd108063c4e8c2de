// SPDX-License-Identifier: BSD-2-Clause
// The description that imported networks become.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "tools/design/import/network.hpp"

namespace mlcca::tools::design {

struct DraftOptions {
  std::string system;                   ///< its name
  std::string gateway;                  ///< empty: none
  std::vector<std::string> interfaces;  ///< of the gateway, one for each network
};

/// The 64 bits of a message: a hash of its network and identifier, so that importing again gives
/// the same. Never 0.
std::uint64_t subject_of(std::string_view network, const ImportedMessage& message);

/// `text` as a name of a description: other characters become '-', a letter in front, cut at 63.
std::string name_from(std::string_view text);

/// The XML. Names that two channels or nodes share get the network's name behind them, or a number,
/// which is added to the lacks of the network.
std::string draft_of(std::vector<ImportedNetwork>& networks, const DraftOptions& options);

}  // namespace mlcca::tools::design
