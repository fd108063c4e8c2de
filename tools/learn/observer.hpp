// SPDX-License-Identifier: BSD-2-Clause
// Collects everything that is seen of several interfaces: the profile of each, the events of each
// publisher, and which events cross from one interface to another.
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

#include "core/profiles/profile.hpp"
#include "tools/learn/crossings.hpp"
#include "tools/learn/datagrams.hpp"
#include "tools/learn/decode.hpp"
#include "tools/learn/flow.hpp"
#include "tools/learn/recognise.hpp"
#include "tools/learn/timeline.hpp"
#include "tools/learn/variety.hpp"

namespace mlcca::learn {

/// Identifies a flow: the events of one publisher of one channel on an interface.
struct FlowKey {
  std::uint32_t interface = 0;
  std::uint64_t number = 0;  ///< of the channel, see Event
  std::uint32_t node = 0;
  bool local = false;  ///< sent by a program of the host
  auto operator<=>(const FlowKey&) const = default;
};

/// What was seen of a flow.
struct Seen {
  Flow flow;
  std::set<std::uint32_t> priorities;  ///< the first 8 priorities
  std::uint32_t frame_bytes = 0;       ///< size of the longest frame
  std::uint64_t fd = 0;                ///< number of events in FD frames
  std::uint64_t remote = 0;            ///< number of remote frames
  std::uint64_t broadcasts = 0;        ///< number of events with Event::broadcast
  std::array<std::uint8_t, 6> mac{};   ///< of the sender of the latest event, on Ethernet
  bool control = false;                ///< control traffic of the profile
  std::uint32_t number = 0;            ///< number of the flow, in order of first appearance
  Variety variety;                     ///< variety of its contents, on CAN
  /// By interface, the events whose frames had been seen on that CAN interface before.
  std::map<std::uint32_t, Crossing> from;
  // Set at the end: the flow on another interface of which this one is a copy.
  std::optional<FlowKey> origin;
  Crossing crossing;
  /// Set if only the content shows that it is a copy, under another identifier.
  std::optional<Crossings::Found> renumbered;
};

/// Recognises copies of CAN frames: the same identifier and data on another interface within
/// kWindow.
class Copies {
 public:
  static constexpr std::uint64_t kWindow = Crossings::kWindow;

  /// Where and when a frame was seen before.
  struct Origin {
    std::uint32_t interface = 0;
    std::uint64_t ns = 0;
  };
  /// The origin of the frame if it is a copy. Each frame has at most one copy on each other
  /// interface.
  std::optional<Origin> origin_of(const Frame& frame);

 private:
  struct Entry {
    std::uint64_t hash = 0;
    std::uint64_t ns = 0;
    std::uint64_t copied_to = 0;  ///< interfaces, one bit each
  };
  static constexpr std::size_t kEntries = 4096;  // for each interface
  std::vector<std::unique_ptr<std::array<Entry, kEntries>>> recent_;
};

/// The collected observations.
class Observer {
 public:
  /// At most so many flows are followed; events of further flows are only counted.
  static constexpr std::size_t kMostFlows = 4096;
  static constexpr std::size_t kMostControl = 16;

  /// States that the following frames are from that recording.
  void begin(const std::string& recording) { recordings_.push_back(recording); }
  /// States the profile of an interface, which is then not recognised from the frames.
  void state(std::uint32_t interface, core::Profile profile);
  /// Takes a frame; frames of interfaces that are read together must be in order of time. Returns
  /// the CAN interface on which the frame was seen before, if it is a copy.
  std::optional<std::uint32_t> add(const Frame& frame);
  /// Decides the profiles of interfaces with fewer than Recogniser::kMost frames, and which events
  /// cross. `interfaces` is their number, including those without any frame; `media` are their
  /// media as far as known.
  void finish(std::size_t interfaces, std::span<const Medium> media = {});

  /// What was seen of an interface.
  struct Interface {
    Medium medium = Medium::unknown;
    Recogniser recogniser;
    std::optional<Recognised> recognised;  ///< nullopt until it is decided
    std::unique_ptr<Decoder> decoder;      ///< for CAN
    std::unique_ptr<Datagrams> datagrams;  ///< for Ethernet
    bool is_stated = false;                ///< its profile was stated
    std::uint64_t frames = 0;
    std::uint64_t unfollowed = 0;  ///< events of flows beyond kMostFlows
    Timeline timeline;
    /// Control frames that no channel can have and that had been seen on another interface before:
    /// their number by identifier and that interface, for the first kMostControl.
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint64_t> crossed_control;
    std::uint64_t slow_bits = 0;  ///< bits of all CAN frames, with stuff bits
    std::uint64_t fast_bits = 0;  ///< those of them in the data phase of FD frames
    /// The percentage of time in which frames were on the bus; nullopt if the rates are not known.
    [[nodiscard]] std::optional<double> load_percent(std::uint32_t bitrate,
                                                     std::uint32_t data_bitrate) const;
  };
  [[nodiscard]] const std::vector<Interface>& interfaces() const { return interfaces_; }
  [[nodiscard]] bool is_ethernet(std::uint32_t interface) const {
    return interfaces_[interface].medium == Medium::ethernet;
  }
  /// After finish().
  [[nodiscard]] core::Profile profile_of(std::uint32_t interface) const {
    return interfaces_[interface].recognised->profile;
  }
  /// Whether senders have node numbers there. FAMOUSO has addresses instead on Ethernet.
  [[nodiscard]] bool has_nodes(std::uint32_t interface) const {
    return !is_ethernet(interface) && core::has_nodes(profile_of(interface));
  }
  [[nodiscard]] const std::vector<std::string>& recordings() const { return recordings_; }
  [[nodiscard]] const std::map<FlowKey, Seen>& flows() const { return flows_; }
  /// Flows with the same content at the same times, perhaps by chance.
  struct Alike {
    FlowKey copy;  ///< the later flow
    FlowKey origin;
    Crossings::Found found;
  };
  [[nodiscard]] const std::vector<Alike>& alike() const { return alike_; }

 private:
  /// A frame that is kept until the profile of its interface is decided.
  struct Kept {
    Frame frame;
    std::array<std::uint8_t, 64> data;
    std::optional<Copies::Origin> origin;
    Stretch stretch;
  };
  Interface& at(std::uint32_t interface);
  void decide(std::uint32_t interface);
  void follow(const Frame& frame, const std::optional<Copies::Origin>& origin, Stretch stretch);
  /// The entry of the flow; nullptr beyond kMostFlows.
  Seen* record(std::uint32_t interface, const Event& event, Stretch stretch);
  [[nodiscard]] const FlowKey* origin_on_can(const FlowKey& key, Seen& seen) const;
  void find_origins();

  std::vector<std::string> recordings_ = {"what was seen"};
  std::vector<Interface> interfaces_;
  std::vector<std::vector<Kept>> kept_;  ///< by interface, until its profile is decided
  std::map<FlowKey, Seen> flows_;
  std::vector<FlowKey> order_;  ///< flows by number
  Copies copies_;
  Crossings crossings_;
  std::vector<Alike> alike_;
};

}  // namespace mlcca::learn
