// SPDX-License-Identifier: BSD-2-Clause
// From frames of a profile to events: whose they are, of which channel, and how long, also where an
// event has several frames.
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

/// Events are compared by so many of their first bytes, and by their length.
inline constexpr std::size_t kHead = 64;

/// On CAN number, node and priority are those of tools::IdentifierParts.
struct Event {
  std::uint64_t ns = 0;
  std::uint64_t number = 0;       ///< on Ethernet: the subject
  std::uint32_t node = 0;         ///< of the sender, where the profile has nodes; or its address
  std::uint32_t priority = 0;     ///< where the profile has priorities, as it has them
  std::uint32_t bytes = 0;        ///< of the event
  std::uint32_t frame_bytes = 0;  ///< of its longest frame
  bool fd = false;
  bool remote = false;
  bool local = false;
  bool control = false;  ///< control traffic that a channel can carry: heart-beats of CANopen
  std::array<std::uint8_t, 6> mac{};  ///< of the sender, on Ethernet; zeros: not known
  /// Its first bytes, up to kHead, valid during the call that hands it over; fewer: not known.
  std::span<const std::uint8_t> head;
};

/// An SDO of CANopen (CiA 301): of a server from 0x581, of a client from 0x601. By these any entry
/// of a node can be written, so that a gate takes them for no control traffic.
[[nodiscard]] constexpr bool is_service(std::uint64_t id) {
  return (id > 0x580 && id < 0x600) || (id > 0x600 && id < 0x680);
}

class Decoder {
 public:
  explicit Decoder(core::Profile profile) : profile_(profile) {}

  using OnEvent = std::function<void(const Event&)>;
  /// Calls `on_event` when the last frame of an event has come.
  void take(const Frame& frame, const OnEvent& on_event);

  [[nodiscard]] core::Profile profile() const { return profile_; }
  /// Frames of the profile's own control traffic, which need no channel.
  [[nodiscard]] std::uint64_t control_frames() const { return control_; }
  /// Of these, those that are no events.
  [[nodiscard]] std::uint64_t lost_control_frames() const { return lost_control_; }
  /// Frames that no channel of the profile can have: services of Cyphal, for example.
  [[nodiscard]] std::uint64_t other_frames() const { return others_; }

 private:
  /// An event of which frames have come.
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
  /// FAMOUSO: learns which tag the broker deals to the subject SUBSCRIB.
  void take_binding(const Frame& frame);
  void take_j1939(const Frame& frame, Event event, const OnEvent& on_event);
  void take_cyphal(const Frame& frame, Event event, const OnEvent& on_event);
  void take_fragment(const Frame& frame, Event event, const OnEvent& on_event);
  /// One more frame; `is_last`: it completes the event, of which `less` bytes are none of its own.
  void go_on(std::uint32_t id, const Event& event, bool is_first, bool is_last, std::uint32_t less,
             const OnEvent& on_event);

  core::Profile profile_;
  std::map<std::uint32_t, Begun> begun_;  ///< by identifier
  /// FAMOUSO: of the subject SUBSCRIB; until it is seen to be dealt, the one that is dealt first.
  std::uint32_t subscribe_tag_ = 0x3fff;
  std::uint32_t half_dealt_ = 0;  ///< to a subject that begins like it
  std::uint64_t control_ = 0;
  std::uint64_t lost_control_ = 0;
  std::uint64_t others_ = 0;
};

}  // namespace mlcca::learn
