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
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tools/learn/crossings.hpp"
#include "tools/learn/datagrams.hpp"
#include "tools/learn/decode.hpp"
#include "tools/learn/flow.hpp"
#include "tools/learn/recognise.hpp"
#include "tools/learn/timeline.hpp"
#include "tools/learn/variety.hpp"

namespace mlcca::learn {

/// Whose events they are, on which interface.
struct FlowKey {
  std::uint32_t interface = 0;
  std::uint64_t number = 0;  ///< of the channel, see Event
  std::uint32_t node = 0;
  bool local = false;  ///< sent by a program of the host
  auto operator<=>(const FlowKey&) const = default;
};

struct Seen {
  Flow flow;
  std::set<std::uint32_t> priorities;  ///< the first 8
  std::uint32_t frame_bytes = 0;       ///< of the longest frame
  std::uint64_t fd = 0;                ///< events in FD frames
  std::uint64_t remote = 0;            ///< remote frames
  std::array<std::uint8_t, 6> mac{};   ///< of the latest event, on Ethernet
  bool control = false;                ///< control traffic of the profile
  std::uint32_t number = 0;            ///< of the flow, in the order in which they began
  Variety variety;                     ///< of its contents, on CAN
  /// Events whose frames had come in on that CAN interface before.
  std::map<std::uint32_t, Crossing> from;
  // Once all of it was seen: the flow whose events these are, on another interface.
  std::optional<FlowKey> origin;
  Crossing crossing;
  /// Where its contents alone say that it is a copy, under another identifier.
  std::optional<Crossings::Found> renumbered;
};

/// Recognises copies of CAN frames: the same identifier and data on another interface within
/// kWindow.
class Copies {
 public:
  static constexpr std::uint64_t kWindow = Crossings::kWindow;

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
  static constexpr std::size_t kMostControl = 16;

  /// What follows is of that recording, or is listened to.
  void begin(const std::string& recording) { recordings_.push_back(recording); }
  /// Of an interface whose profile is stated.
  void state(std::uint32_t interface, core::Profile profile);
  /// Frames in the order of their times, as far as their interfaces are read together. Returns the
  /// CAN interface on which the frame was seen before, if it is a copy.
  std::optional<std::uint32_t> add(const Frame& frame);
  /// What is recognised with fewer frames than Recogniser::kMost is decided now, and what crosses.
  /// There are so many interfaces, some perhaps without a frame; of these the medium may be known.
  void finish(std::size_t interfaces, std::span<const Medium> media = {});

  struct Interface {
    Medium medium = Medium::unknown;
    Recogniser recogniser;
    std::optional<Recognised> recognised;  ///< once it is decided
    std::unique_ptr<Decoder> decoder;      ///< of CAN
    std::unique_ptr<Datagrams> datagrams;  ///< of Ethernet
    bool is_stated = false;                ///< its profile
    std::uint64_t frames = 0;
    std::uint64_t unfollowed = 0;  ///< events of flows beyond kMostFlows
    Timeline timeline;
    /// Frames of control traffic that had been on another interface before, by identifier and that
    /// interface: those that no channel can have, the first kMostControl.
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint64_t> crossed_control;
    std::uint64_t slow_bits = 0;  ///< of all frames of CAN, with their stuff bits
    std::uint64_t fast_bits = 0;  ///< of these, in the data phase of FD frames
    /// How much of the time frames were on the bus; nothing where the rates are not known.
    [[nodiscard]] std::optional<double> load_percent(std::uint32_t bitrate,
                                                     std::uint32_t data_bitrate) const;
  };
  [[nodiscard]] const std::vector<Interface>& interfaces() const { return interfaces_; }
  [[nodiscard]] const std::vector<std::string>& recordings() const { return recordings_; }
  [[nodiscard]] const std::map<FlowKey, Seen>& flows() const { return flows_; }
  /// Flows of the same content at the same times, that may be so by chance.
  struct Alike {
    FlowKey copy;  ///< the later one
    FlowKey origin;
    Crossings::Found found;
  };
  [[nodiscard]] const std::vector<Alike>& alike() const { return alike_; }

 private:
  struct Kept {
    Frame frame;
    std::array<std::uint8_t, 64> data;
    std::optional<Copies::Origin> origin;
    Stretch stretch;
  };
  Interface& at(std::uint32_t interface);
  void decide(std::uint32_t interface);
  void follow(const Frame& frame, const std::optional<Copies::Origin>& origin, Stretch stretch);
  /// Nothing: it is one flow too many.
  Seen* record(std::uint32_t interface, const Event& event, Stretch stretch);
  [[nodiscard]] const FlowKey* origin_on_can(const FlowKey& key, Seen& seen) const;
  void find_origins();

  std::vector<std::string> recordings_ = {"what was seen"};
  std::vector<Interface> interfaces_;
  std::vector<std::vector<Kept>> kept_;  ///< of each interface, until its profile is decided
  std::map<FlowKey, Seen> flows_;
  std::vector<FlowKey> order_;  ///< flows by their numbers
  Copies copies_;
  Crossings crossings_;
  std::vector<Alike> alike_;
};

}  // namespace mlcca::learn
