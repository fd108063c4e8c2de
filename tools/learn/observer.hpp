// SPDX-License-Identifier: BSD-2-Clause
// Everything that is seen of some interfaces: the profile of each, the events of each publisher,
// and which events cross from one interface to another.
#pragma once
#include <array>
#include <compare>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "tools/learn/decode.hpp"
#include "tools/learn/flow.hpp"
#include "tools/learn/recognise.hpp"

namespace mlcca::learn {

/// Whose events they are, on which interface.
struct FlowKey {
  std::uint32_t interface = 0;
  std::uint32_t number = 0;  ///< of the channel, see Event
  std::uint32_t node = 0;
  bool local = false;  ///< sent by a program of the host
  auto operator<=>(const FlowKey&) const = default;
};

/// Of frames that came in on one interface and left by another.
struct Crossing {
  std::uint64_t events = 0;
  std::uint64_t longest_ns = 0;
  std::uint64_t shortest_ns = UINT64_MAX;
};

struct Seen {
  Flow flow;
  std::set<std::uint32_t> priorities;  ///< the first 8
  std::uint32_t frame_bytes = 0;       ///< of the longest frame
  std::uint64_t fd = 0;                ///< events in FD frames
  std::uint64_t remote = 0;            ///< remote frames
  /// Events that had come in on that interface before.
  std::map<std::uint32_t, Crossing> from;
};

/// Recognises copies of frames: the same identifier and data on another interface within kWindow.
class Copies {
 public:
  static constexpr std::uint64_t kWindow = 100'000'000;  // ns

  struct Origin {
    std::uint32_t interface = 0;
    std::uint64_t ns = 0;
  };
  /// Where the frame was before, if it is a copy; each frame has one copy on each other interface.
  std::optional<Origin> origin_of(const Frame& frame);

 private:
  struct Entry {
    std::uint64_t hash = 0;
    std::uint64_t ns = 0;
    std::uint64_t copied_to = 0;  ///< interfaces, a bit each
  };
  static constexpr std::size_t kEntries = 4096;  // of each interface
  std::vector<std::unique_ptr<std::array<Entry, kEntries>>> recent_;
};

class Observer {
 public:
  /// Flows that are followed; frames of further ones are counted.
  static constexpr std::size_t kMostFlows = 4096;

  /// Of an interface whose profile is stated.
  void state(std::uint32_t interface, core::Profile profile);
  /// Frames in the order of their times.
  void add(const Frame& frame);
  /// What is recognised with fewer frames than Recogniser::kMost is decided now. There are so many
  /// interfaces, some perhaps without a frame.
  void finish(std::size_t interfaces);

  struct Interface {
    Recogniser recogniser;
    std::optional<Recognised> recognised;  ///< once it is decided
    std::unique_ptr<Decoder> decoder;
    std::uint64_t frames = 0;
    std::uint64_t unfollowed = 0;  ///< events of flows beyond kMostFlows
  };
  [[nodiscard]] const std::vector<Interface>& interfaces() const { return interfaces_; }
  [[nodiscard]] const std::map<FlowKey, Seen>& flows() const { return flows_; }

 private:
  struct Kept {
    Frame frame;
    std::array<std::uint8_t, 64> data;
    std::optional<Copies::Origin> origin;
  };
  Interface& at(std::uint32_t interface);
  void decide(std::uint32_t interface);
  void follow(const Frame& frame, const std::optional<Copies::Origin>& origin);

  std::vector<Interface> interfaces_;
  std::vector<std::vector<Kept>> kept_;  ///< of each interface, until its profile is decided
  std::map<FlowKey, Seen> flows_;
  Copies copies_;
};

}  // namespace mlcca::learn
