// SPDX-License-Identifier: BSD-2-Clause
// Events in CAN frames, according to the profile of the bus:
//
//   famouso   up to 8 octets in a frame; longer ones in fragments, with bit 21 of the identifier
//   cyphal    transfers of one frame or of several
//   j1939     the data of a frame; longer ones by the transport protocol
//   others    the data of a frame
//
// The identifiers are those that the gate admits; see core/profiles.
#pragma once
#include <linux/can.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/handle.hpp"
#include "relay/afp.hpp"
#include "relay/cyphal.hpp"
#include "relay/j1939.hpp"
#include "relay/layers/alarm.hpp"
#include "relay/layers/layer.hpp"

namespace mlcca::relay {

/// The interface between a layer and its bus, which tests replace.
class FrameSocket {
 public:
  struct Frame {
    canfd_frame frame{};
    bool fd = false;
    bool local = false;  ///< sent by a program on this host
    std::uint64_t unix_ns = 0;
  };

  FrameSocket() = default;
  FrameSocket(const FrameSocket&) = delete;
  FrameSocket& operator=(const FrameSocket&) = delete;
  FrameSocket(FrameSocket&&) = delete;
  FrameSocket& operator=(FrameSocket&&) = delete;
  virtual ~FrameSocket() = default;

  [[nodiscard]] virtual int fd() const = 0;
  /// Receives only frames that match one of the filters.
  [[nodiscard]] virtual Result<void> filter(const std::vector<can_filter>& filters) = 0;
  /// The result of receive(); `gone`: the interface is gone.
  enum class Got : std::uint8_t { frame, nothing, gone };
  virtual Got receive(Frame& to) = 0;
  /// Whether receive() has frames that a poll of the descriptor does not report.
  [[nodiscard]] virtual bool pending() const { return false; }
  virtual Sent send(const canfd_frame& frame, bool fd) = 0;
  [[nodiscard]] virtual std::uint64_t dropped() const = 0;
};

/// Opens a socket on a bus. Without a filter it receives nothing; frames of programs on this host
/// are received as well.
[[nodiscard]] Result<std::unique_ptr<FrameSocket>> open_frame_socket(std::uint32_t ifindex);

/// The layer of a CAN interface.
class CanLayer : public Layer {
 public:
  static Result<std::unique_ptr<Layer>> open(const control::Endpoint& endpoint);
  /// `alarm`: combined with the socket if frames may have to wait; without it they are sent when
  /// receive() is called. `now`: CLOCK_MONOTONIC in ns.
  explicit CanLayer(std::unique_ptr<FrameSocket> socket, std::unique_ptr<Alarm> alarm = nullptr,
                    std::uint64_t (*now)() = monotonic_ns)
      : socket_(std::move(socket)), alarm_(std::move(alarm)), now_(now) {}

  [[nodiscard]] int fd() const override { return alarm_ ? alarm_->fd() : socket_->fd(); }
  [[nodiscard]] Result<void> follow(Follower follower, const control::Endpoint& endpoint,
                                    std::uint64_t subject, std::size_t longest) override;
  void leave(Follower follower, const control::Endpoint& endpoint, std::uint64_t subject) override;
  bool receive(std::size_t most, const OnEvent& on_event) override;
  void expire() override;
  [[nodiscard]] bool holds_parts() const override {
    return fragments_.begun() + transfers_.octets() + messages_.sessions() != 0;
  }
  Sent send(const control::Endpoint& endpoint, std::uint64_t subject, Octets event) override;
  [[nodiscard]] Losses losses() const override;

 private:
  /// How events are put into frames; `transport` is J1939 with its transport protocol.
  enum class Form : std::uint8_t { plain, famouso, cyphal, transport };
  /// A follower, the form of its events, and the frame formats that it takes.
  struct Following {
    Follower follower = 0;
    Form form = Form::plain;
    bool classic = false;
    bool fd = false;
    std::size_t longest = 0;
    [[nodiscard]] bool takes(const FrameSocket::Frame& frame) const {
      return frame.fd ? fd : classic;
    }
  };
  /// The followers of one mask, by the masked identifier.
  using ById = std::unordered_map<std::uint32_t, std::vector<Following>>;

  /// Identifier and mask of frames that carry messages of several channels.
  using Carrier = std::pair<std::uint32_t, std::uint32_t>;

  static Result<Form> form_of(const control::Endpoint& endpoint);
  void follow_carriers(const control::Endpoint& endpoint, bool more);
  [[nodiscard]] std::size_t filters() const;
  [[nodiscard]] Result<void> set_filters(std::size_t before);
  [[nodiscard]] static bool is_complete(Form form, std::uint32_t id);
  void take(const FrameSocket::Frame& frame, const OnEvent& on_event);
  void take_announcement(std::uint32_t id, Octets data);
  void take_packet(const FrameSocket::Frame& frame, Octets data, const OnEvent& on_event);
  template <class Use>
  void each_of(std::uint32_t id, const Use& use) const;
  void hand_over(const Following& to, const FrameSocket::Frame& last, Octets event,
                 const OnEvent& on_event);
  Sent send_frame(const control::Endpoint& endpoint, std::uint32_t id, Octets data);
  Sent send_fragments(const control::Endpoint& endpoint, Octets event);
  Sent send_transfer(const control::Endpoint& endpoint, Octets event);
  Sent send_message(const control::Endpoint& endpoint, Octets event);
  Sent send_due(std::uint32_t first);

  std::unique_ptr<FrameSocket> socket_;
  std::unique_ptr<Alarm> alarm_;
  std::uint64_t (*now_)();
  std::map<std::uint32_t, ById> by_mask_;
  std::size_t identities_ = 0;               ///< identities of all masks
  std::map<Carrier, std::size_t> carriers_;  ///< with the number of identities that need each
  afp::Reassembly fragments_{afp::kCan};
  cyphal::Reassembly transfers_;
  j1939::Reassembly messages_;
  j1939::Sending sending_;
  std::unordered_map<std::uint32_t, std::uint8_t>
      numbers_;  ///< transfer-ID of the next Cyphal transfer, by identifier
  Losses losses_;
};

}  // namespace mlcca::relay
