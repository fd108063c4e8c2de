// SPDX-License-Identifier: BSD-2-Clause
// Finds out which events are forwarded between a CAN bus and an Ethernet, between two Ethernets, or
// between CAN buses under another identifier. Only the content and the times of events show that.
// Everything is decided at the end, because recordings of several interfaces may be read one after
// another.
#pragma once
#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace mlcca::learn {

/// Counts events that arrived on one interface and left by another, with their delays in ns.
struct Crossing {
  std::uint64_t events = 0;
  std::uint64_t longest_ns = 0;
  std::uint64_t shortest_ns = UINT64_MAX;

  void add(std::uint64_t ns);
};

/// Collects the contents of events of all flows and finds flows that are copies of others.
class Crossings {
 public:
  /// The longest forwarding delay of a gateway that is considered, in ns.
  static constexpr std::uint64_t kWindow = 100'000'000;
  /// At most so many events are kept. With more traffic only some spans of time are kept, the same
  /// ones on all interfaces.
  static constexpr std::size_t kMost = std::size_t{1} << 19U;

  explicit Crossings(std::size_t most = kMost) : most_(most) {}

  /// Adds an event: `flow` is the number of its flow, from 0; `content` is a hash of its content.
  void add(std::uint32_t flow, std::uint32_t interface, std::uint64_t ns, std::uint64_t content);

  /// What is known about a flow, for find().
  struct Of {
    std::uint32_t interface = 0;
    bool ethernet = false;
    std::uint64_t number = 0;  ///< number of the channel, see Event
    bool local = false;
    bool changes = true;                  ///< of CAN: see Variety::changes()
    bool rich = true;                     ///< of CAN: see Variety::is_rich()
    std::optional<std::uint32_t> origin;  ///< the flow of which it is known to be a copy
  };
  /// A pair of flows of which one is probably a copy of the other.
  struct Found {
    std::uint32_t copy = 0;
    std::uint32_t origin = 0;
    Crossing crossing;
    /// False if the content hardly changes, or changes like a counter, so that the contents may
    /// agree by chance. Such a copy is not used as the origin of others.
    bool sure = true;
    bool renumbered = false;      ///< from one bus to another under another identifier
    std::uint64_t of = 0;         ///< events of the copy that could be compared
    std::uint64_t contents = 0;   ///< about how many different contents there were
    std::uint64_t of_origin = 0;  ///< events of the origin that could have been copied
    /// The number of those events of the copy that agree. At the end of a span of time, events can
    /// be counted in `crossing` that are not in `of`.
    [[nodiscard]] std::uint64_t agreed() const { return std::min(crossing.events, of); }
    /// The percentage of events that agree, for the copy or the origin, whichever is smaller.
    [[nodiscard]] unsigned percent() const;
  };
  /// Finds the copies; `flows` is indexed by flow number.
  [[nodiscard]] std::vector<Found> find(std::vector<Of> flows);

 private:
  /// An event that is kept.
  struct Record {
    std::uint64_t content = 0;
    std::uint64_t ns = 0;
    std::uint32_t flow = 0;
    auto operator<=>(const Record&) const = default;
  };
  /// Events of one flow (the copy) whose content was in another flow (the origin) shortly before.
  struct Pair {
    Crossing crossing;
    std::uint64_t sum_ns = 0;
    std::uint32_t contents = 0;   ///< number of different contents
    std::uint64_t content = 0;    ///< the latest content
    std::size_t used_origin = 0;  ///< index after the latest record of the origin that was used
    std::size_t used_copy = 0;    ///< the same for the copy
  };
  /// The times of the first and last event of an interface.
  struct Observed {
    std::uint64_t first = UINT64_MAX;
    std::uint64_t last = 0;
  };
  struct Candidate;

  /// Whether the events of that span of time (its number) are kept.
  [[nodiscard]] bool is_kept(std::uint64_t span) const;
  [[nodiscard]] bool is_inner(std::uint64_t ns) const;
  void compare(std::span<const Of> flows);
  void compare(std::span<const Of> flows, std::size_t copy, std::size_t first);
  void count_comparable(std::span<const Of> flows);
  [[nodiscard]] std::uint64_t comparable(std::uint32_t flow, std::uint32_t interface) const;
  [[nodiscard]] static bool is_sure(const Found& found, const Of& copy);
  [[nodiscard]] std::vector<Candidate> candidates(std::span<const Of> flows) const;

  std::size_t most_;
  std::vector<Record> records_;
  std::uint64_t mask_ = 0;          ///< a span is kept if the bits of this mask are 0 in its hash
  std::vector<Observed> observed_;  ///< by interface
  std::vector<std::uint32_t> comparable_;  ///< number of events, by flow and interface
  std::map<std::pair<std::uint32_t, std::uint32_t>, Pair> pairs_;  ///< by copy and origin
};

}  // namespace mlcca::learn
