// SPDX-License-Identifier: BSD-2-Clause
// Decodes the frames of a profile into events: sender, channel and size, also of events in several
// frames.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>

#include "core/model/system.hpp"
#include "tools/learn/frame.hpp"

namespace mlcca::learn {

/// Events are compared by their length and at most so many of their first bytes.
inline constexpr std::size_t kHead = 64;

/// A decoded event. For CAN, number, node and priority are as in tools::IdentifierParts.
struct Event {
  std::uint64_t ns = 0;
  std::uint64_t number = 0;       ///< of its channel; on Ethernet the subject
  std::uint32_t node = 0;         ///< of the sender, in profiles that have nodes; or its address
  std::uint32_t priority = 0;     ///< in profiles that have priorities, in the profile's own scale
  std::uint32_t bytes = 0;        ///< size of the event
  std::uint32_t frame_bytes = 0;  ///< size of its longest frame
  bool fd = false;
  bool remote = false;
  bool local = false;
  bool control = false;    ///< control traffic that can be a channel: heart-beats of CANopen
  bool broadcast = false;  ///< on Ethernet: it went to the port of FAMOUSO's broadcasts
  std::array<std::uint8_t, 6> mac{};  ///< of the sender on Ethernet; zeros: not known
  /// The first bytes of its data, up to kHead, valid only during the call; fewer if they are not
  /// known.
  std::span<const std::uint8_t> head;
};

/// Whether the identifier is an SDO of CANopen (CiA 301): 0x581 and following of a server, 0x601
/// and following of a client. With SDOs any entry of a node can be written, so a gate does not
/// treat them as control traffic.
[[nodiscard]] constexpr bool is_service(std::uint64_t id) {
  return (id > 0x580 && id < 0x600) || (id > 0x600 && id < 0x680);
}

/// Decodes the frames of one CAN interface.
class Decoder {
 public:
  explicit Decoder(core::Profile profile) : profile_(profile) {}

  using OnEvent = std::function<void(const Event&)>;
  /// Takes a frame. Calls `on_event` when the last frame of an event has arrived.
  void take(const Frame& frame, const OnEvent& on_event);

  [[nodiscard]] core::Profile profile() const { return profile_; }
  /// The number of frames of the profile's own control traffic that are not reported as events.
  [[nodiscard]] std::uint64_t lost_control_frames() const { return lost_control_; }
  /// The number of frames that no channel of the profile can have, such as services of Cyphal.
  [[nodiscard]] std::uint64_t other_frames() const { return others_; }

 private:
  /// An event of which some frames have arrived.
  struct Begun {
    Event event;
    std::uint64_t latest = 0;
    std::array<std::uint8_t, kHead> head{};
    std::size_t head_bytes = 0;
    void add_head(std::span<const std::uint8_t> data);
  };
  static constexpr std::size_t kMostBegun = 1024;

  [[nodiscard]] bool is_control(const Frame& frame) const;
  static bool is_heart_beat(const Frame& frame);
  /// FAMOUSO: learns the tag that the broker assigns to the subject SUBSCRIB.
  void take_binding(const Frame& frame);
  void take_j1939(const Frame& frame, Event event, const OnEvent& on_event);
  void take_cyphal(const Frame& frame, Event event, const OnEvent& on_event);
  void take_fragment(const Frame& frame, Event event, const OnEvent& on_event);
  /// Adds a frame to an event. With `is_last` it completes the event, and `less` of its bytes are
  /// not data of the event.
  void go_on(std::uint32_t id, const Event& event, bool is_first, bool is_last, std::uint32_t less,
             const OnEvent& on_event);

  core::Profile profile_;
  std::map<std::uint32_t, Begun> begun_;  ///< by identifier
  /// FAMOUSO: tag of the subject SUBSCRIB; initially the one that a broker assigns first.
  std::uint32_t subscribe_tag_ = 0x3fff;
  std::uint32_t half_dealt_ = 0;  ///< a tag assigned to a subject with the same beginning
  std::uint64_t lost_control_ = 0;
  std::uint64_t others_ = 0;
};

}  // namespace mlcca::learn
