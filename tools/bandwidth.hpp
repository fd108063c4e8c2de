// SPDX-License-Identifier: BSD-2-Clause
// mlccactl bandwidth: what a chain of radio links carries, computed without the daemon.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"

namespace mlcca::tools {

/// The arguments as typed; an empty one is not given.
struct BandwidthArguments {
  std::vector<std::string> rates;       ///< RATE or RATE:LOSS of each link, in order
  std::optional<std::uint32_t> packet;  ///< payload of a packet in bytes
  std::optional<std::uint32_t> header;  ///< header of a packet in bytes
  std::string overhead;                 ///< time for a packet beside its bits, in µs
  std::string loss;
  std::string limit;
  std::string background;
  std::string domain;
  std::string demand;
};

/// The result in both output forms.
struct BandwidthAnswer {
  std::string text;  ///< lines for a person; the first one is the rate by the paper's equation (1/R
                     ///< = sum of 1/R_link)
  std::string json;  ///< one object on one line
  bool fits = true;  ///< the demand fits, or there is none
};

/// Evaluates the chain. An error states which argument is wrong and what would be right.
Result<BandwidthAnswer> bandwidth(const BandwidthArguments& arguments);

}  // namespace mlcca::tools
