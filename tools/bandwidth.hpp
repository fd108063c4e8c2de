// SPDX-License-Identifier: BSD-2-Clause
// mlccactl bandwidth: what a chain of radio links carries, without asking anyone.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"

namespace mlcca::tools {

/// As typed; empty: not given.
struct BandwidthArguments {
  std::vector<std::string> rates;       ///< RATE or RATE:LOSS of each link
  std::optional<std::uint32_t> packet;  ///< bytes of payload
  std::optional<std::uint32_t> header;  ///< bytes
  std::string overhead;                 ///< us
  std::string loss;
  std::string limit;
  std::string background;
  std::string domain;
  std::string demand;
};

struct BandwidthAnswer {
  std::string text;  ///< lines for a person; the first is the rate by the paper's equation alone
  std::string json;  ///< one object on one line
  bool fits = true;  ///< the demand, if there is one
};

/// An error says which argument is wrong and what would be right.
Result<BandwidthAnswer> bandwidth(const BandwidthArguments& arguments);

}  // namespace mlcca::tools
