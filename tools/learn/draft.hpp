// SPDX-License-Identifier: BSD-2-Clause
// A description drafted from what was seen: channels with their values, and what margin each has.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tools/learn/observer.hpp"

namespace mlcca::learn {

struct DraftOptions {
  // Names that a description may have:
  std::string system = "learned";
  std::string gateway = "gateway";
  std::map<std::string, std::uint32_t> bitrates = {};       ///< bit/s, by interface
  std::map<std::string, std::uint32_t> data_bitrates = {};  ///< the same of the FD data phase
  /// Names of networks that are described already, by interface.
  std::map<std::string, std::string> networks = {};
  std::string user = "root";      ///< of programs on the gateway that send
  bool local_subscribers = true;  ///< programs on the gateway receive what comes
};

/// One channel as it is drafted, for a table and for tests.
struct DraftChannel {
  std::string name;
  std::string interface;
  std::string identifier;  ///< as a person writes it
  std::uint64_t events = 0;
  std::uint64_t period = 0;       ///< ns, as it is stated
  std::uint64_t jitter = 0;       ///< ns
  std::uint64_t median = 0;       ///< ns between events, as it was seen
  std::uint64_t longest_gap = 0;  ///< ns
  std::uint64_t omission = 0;     ///< stated; of periodic channels
  std::uint32_t bytes = 0;
  bool periodic = false;
  std::vector<std::string> publishers;
  std::vector<std::uint32_t> nodes;     ///< of these publishers, where the profile has nodes
  std::vector<std::string> crosses_to;  ///< interfaces
  std::uint32_t number = 0;             ///< see Event
  // The elements of the description, each in lines of its own:
  std::string channel_xml;
  std::map<std::string, std::string> binding_xml = {};  ///< by interface
  std::vector<std::string> publisher_xml;
  std::string subscriber_xml;
};

struct Draft {
  std::string xml;
  std::vector<DraftChannel> channels;
  /// What was seen and has no place in the description, a line each.
  std::vector<std::string> left_out;
};

/// `names`: of the interfaces, by their numbers.
[[nodiscard]] Draft draft_of(const Observer& observer, const std::vector<std::string>& names,
                             const DraftOptions& options);

}  // namespace mlcca::learn
