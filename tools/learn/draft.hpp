// SPDX-License-Identifier: BSD-2-Clause
// A description drafted from what was seen: channels with their values, and what margin each has.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tools/elements.hpp"
#include "tools/learn/observer.hpp"

namespace mlcca::learn {

struct DraftOptions {
  // Names that a description may have:
  std::string system = "learned";
  std::string gateway = "gateway";
  std::map<std::string, std::uint32_t> bitrates = {};       ///< bit/s, by interface
  std::map<std::string, std::uint32_t> data_bitrates = {};  ///< the same of the FD data phase
  /// Interfaces whose rates are assumed to be those of a fast bus, where none are stated.
  std::set<std::string> fast = {};
  std::set<std::string> made_up = {};  ///< names of interfaces that no recording has
  std::map<std::string, std::uint32_t> queue_lengths = {};  ///< frames that fit, by interface
  /// Frames that may wait there, by interface: where more than fit a queue by default.
  std::map<std::string, std::uint32_t> waiting = {};
  /// Names of networks that are described already, by interface.
  std::map<std::string, std::string> networks = {};
  /// Names of channels that state a Deadline, ns; see deadlines_that_hold().
  std::map<std::string, std::uint64_t> deadlines = {};
  /// Names of channels with few events whose Period is the mean of their gaps and not half of it.
  std::set<std::string> at_mean = {};
  /// Of what was seen so seldom that nothing says how often it comes, ns.
  std::uint64_t assumed_period = tools::kPeriodOfOne;
  std::string user = "root";      ///< of programs on the gateway that send
  bool local_subscribers = true;  ///< programs on the gateway receive what comes
};

/// A publisher as it is drafted.
struct DraftPublisher {
  std::string name;
  std::string interface;     ///< where it sends
  std::uint32_t node = 0;    ///< where the profile has nodes; on Ethernet its address
  bool local = false;        ///< a program on the gateway
  std::uint64_t period = 0;  ///< ns, as it is stated
  std::uint32_t bytes = 0;
  bool periodic = false;
  std::string xml;
  std::uint64_t events = 0;
  std::uint64_t shorter_events = 0;  ///< of fewer than `bytes`
  std::uint32_t least_bytes = 0;
};

/// One channel as it is drafted, for a table and for tests.
struct DraftChannel {
  std::string name;
  std::string interface;
  std::string identifier;  ///< as a person writes it
  std::uint64_t events = 0;
  std::uint64_t period = 0;       ///< ns, as it is stated: the longest of its publishers
  std::uint64_t jitter = 0;       ///< ns
  std::uint64_t median = 0;       ///< ns between events, as it was seen
  std::uint64_t longest_gap = 0;  ///< ns
  std::uint64_t omission = 0;     ///< stated; of periodic channels
  std::uint32_t bytes = 0;
  double bytes_per_second = 0;  ///< as it was seen
  bool periodic = false;
  bool on_events = false;  ///< periodic, with further events in between
  bool bursts = false;
  bool control = false;  ///< control traffic of its profile that crosses
  std::vector<DraftPublisher> publishers;
  std::vector<std::string> crosses_to;           ///< interfaces
  std::map<std::string, std::uint64_t> numbers;  ///< see Event, by interface
  std::optional<std::uint64_t> subject;          ///< that was seen on Ethernet
  std::uint64_t drafted_subject = 0;             ///< the same, or one that was made for it
  // The elements of the description, each in lines of its own:
  std::string channel_xml;
  std::map<std::string, std::string> binding_xml = {};  ///< by interface of CAN
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
