// SPDX-License-Identifier: BSD-2-Clause
// Drafts a description from the observed channels.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tools/elements.hpp"
#include "tools/learn/channels.hpp"
#include "tools/learn/observer.hpp"

namespace mlcca::learn {

/// The options of a draft. Times are in ns; interfaces are named as in the recording.
struct DraftOptions {
  // Names that a description may have:
  std::string system = "learned";
  std::string gateway = "gateway";
  std::map<std::string, std::uint32_t> bitrates = {};  ///< bit/s, by interface
  /// Bit/s in the data phase of FD frames, by interface.
  std::map<std::string, std::uint32_t> data_bitrates = {};
  /// Interfaces without a stated bit rate for which the rates of a fast bus are assumed.
  std::set<std::string> fast = {};
  std::set<std::string> made_up = {};  ///< names of interfaces that do not come from a recording
  /// Number of frames that fit the queue, by interface.
  std::map<std::string, std::uint32_t> queue_lengths = {};
  /// Number of frames that may wait, by interface, where more than a default queue can hold.
  std::map<std::string, std::uint32_t> waiting = {};
  /// Names of networks that a description already has, by interface.
  std::map<std::string, std::string> networks = {};
  /// Deadlines that are stated, by name of the channel; see deadlines_that_hold().
  std::map<std::string, std::uint64_t> deadlines = {};
  /// Channels with few events whose Period is the mean of their gaps, instead of half of it.
  std::set<std::string> at_mean = {};
  TimesOptions times = {};        ///< assumptions about how often events come
  std::string user = "root";      ///< user of programs on the gateway that send
  bool local_subscribers = true;  ///< programs on the gateway receive what comes in
};

/// A drafted publisher.
struct DraftPublisher {
  std::string name;
  std::string interface;     ///< interface by which it sends
  std::uint32_t node = 0;    ///< if the profile has nodes; on Ethernet the address
  bool local = false;        ///< a program on the gateway
  std::uint64_t period = 0;  ///< stated Period, ns
  std::uint64_t jitter = 0;  ///< stated Jitter, ns
  std::uint32_t bytes = 0;
  bool periodic = false;
  std::string xml;
  std::uint64_t events = 0;
  std::uint64_t shorter_events = 0;  ///< number of events with fewer than `bytes` bytes
  std::uint32_t least_bytes = 0;
  std::uint64_t shortest_gap = 0;  ///< ns
  std::vector<Rate> rates;         ///< see Flow::rates() and longer_rates(); of many events
  std::vector<Flow::Moment> few;   ///< see Flow::few(): its Period is not what was seen
  bool assumed = false;            ///< see Times::assumed
};

/// A drafted channel, for a table and for tests.
struct DraftChannel {
  /// What was observed of the times between its events.
  struct Gaps {
    std::uint64_t median = 0;         ///< ns
    std::uint64_t mean = 0;           ///< ns, of the publisher whose events come most often
    std::uint64_t shortest = 0;       ///< ns
    std::uint64_t longest = 0;        ///< ns
    std::uint64_t pauses = 0;         ///< of cyclic traffic, see Flow::Pauses
    std::uint64_t longest_pause = 0;  ///< ns
  };
  std::string name;
  std::string interface;
  std::string identifier;  ///< as people write it
  std::string seen;        ///< see seen_in_words(), of its first publisher
  std::uint64_t events = 0;
  std::uint64_t period = 0;  ///< stated Period in ns: the longest one of its publishers
  std::uint64_t jitter = 0;  ///< ns
  Gaps gaps;
  std::uint64_t omission = 0;  ///< stated Omission; only periodic channels have one
  std::uint32_t bytes = 0;
  std::optional<double> bytes_per_second;  ///< observed; nullopt: too few events to tell
  bool periodic = false;
  bool on_events = false;  ///< periodic, with further events in between
  bool bursts = false;
  bool few = false;      ///< too few events to tell whether it is periodic
  bool control = false;  ///< control traffic of its profile that crosses the gateway
  std::vector<DraftPublisher> publishers;
  std::vector<std::string> crosses_to;           ///< interfaces
  std::map<std::string, std::uint64_t> numbers;  ///< Event::number, by interface
  std::optional<std::uint64_t> subject;          ///< the subject that was seen on Ethernet
  std::uint64_t drafted_subject = 0;             ///< that subject, or one that was generated
  // The elements of the description, as complete lines:
  std::string channel_xml;
  std::map<std::string, std::string> binding_xml = {};  ///< by interface of CAN
  std::string subscriber_xml;
};

struct Draft {
  std::string xml;
  std::vector<DraftChannel> channels;
  /// How events came, by interface of Ethernet.
  std::map<std::string, Transports> transports;
  /// What was observed and has no place in the description, one line each.
  std::vector<std::string> left_out;
};

/// Drafts the description. `names` are the names of the interfaces, by their numbers.
[[nodiscard]] Draft draft_of(const Observer& observer, const std::vector<std::string>& names,
                             const DraftOptions& options);

}  // namespace mlcca::learn
