// SPDX-License-Identifier: BSD-2-Clause
// Which events go on between a CAN bus and an Ethernet, from one Ethernet to another, or from a CAN
// bus to another one under another identifier. Only what events contain says so, and when they were
// there. All of it is decided at the end: recordings of several interfaces may be read one after
// the other.
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

/// Of events that came in on one interface and left by another.
struct Crossing {
  std::uint64_t events = 0;
  std::uint64_t longest_ns = 0;
  std::uint64_t shortest_ns = UINT64_MAX;

  void add(std::uint64_t ns);
};

class Crossings {
 public:
  /// So long a gateway takes at most, ns.
  static constexpr std::uint64_t kWindow = 100'000'000;
  /// Events that are kept. Of more traffic whole stretches of time are, of all interfaces the same.
  static constexpr std::size_t kMost = std::size_t{1} << 19U;

  explicit Crossings(std::size_t most = kMost) : most_(most) {}

  /// `flow`: its number, counted from 0.
  void add(std::uint32_t flow, std::uint32_t interface, std::uint64_t ns, std::uint64_t content);

  /// What is known of a flow otherwise.
  struct Of {
    std::uint32_t interface = 0;
    bool ethernet = false;
    std::uint64_t number = 0;  ///< of its channel
    bool local = false;
    bool changes = true;                  ///< see Variety; of CAN
    bool rich = true;                     ///< the same
    std::optional<std::uint32_t> origin;  ///< the flow that it is a copy of
  };
  struct Found {
    std::uint32_t copy = 0;
    std::uint32_t origin = 0;
    Crossing crossing;
    /// False: the content hardly changes, or as a counter does, so that chance may have made them
    /// alike. Such copies are no origins of others.
    bool sure = true;
    bool renumbered = false;      ///< from one bus to another
    std::uint64_t of = 0;         ///< events of the copy that could be compared
    std::uint64_t contents = 0;   ///< different ones, about
    std::uint64_t of_origin = 0;  ///< events of the origin that could have been copied
    /// Of these, those that are copies. Of a stretch of time at whose end others are not kept, some
    /// are, that could not be compared from both sides.
    [[nodiscard]] std::uint64_t agreed() const { return std::min(crossing.events, of); }
    /// The share of events that agree, of the copy or of the origin, whichever is less.
    [[nodiscard]] unsigned percent() const;
  };
  /// `flows`: by their numbers.
  [[nodiscard]] std::vector<Found> find(std::vector<Of> flows);

 private:
  struct Record {
    std::uint64_t content = 0;
    std::uint64_t ns = 0;
    std::uint32_t flow = 0;
    auto operator<=>(const Record&) const = default;
  };
  /// Events of one flow that had been there as those of another.
  struct Pair {
    Crossing crossing;
    std::uint64_t sum_ns = 0;
    std::uint32_t contents = 0;   ///< different ones
    std::uint64_t content = 0;    ///< the latest
    std::size_t used_origin = 0;  ///< the latest record, and one
    std::size_t used_copy = 0;    ///< the same
  };
  struct Heard {
    std::uint64_t first = UINT64_MAX;
    std::uint64_t last = 0;
  };
  struct Candidate;

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
  std::uint64_t mask_ = 0;                 ///< one stretch of time in so many and one is kept
  std::vector<Heard> heard_;               ///< by interface
  std::vector<std::uint32_t> comparable_;  ///< by flow and interface
  std::map<std::pair<std::uint32_t, std::uint32_t>, Pair> pairs_;  ///< by copy and origin
};

}  // namespace mlcca::learn
