// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's events in data frames of IEEE 802.15.4. The payload of the MAC frame is
//
//   subject[8] event
//
// without a flag, because nothing is fragmented. Frames are broadcast in the interface's own PAN,
// from its short address.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "relay/layers/followers.hpp"
#include "relay/layers/layer.hpp"

namespace mlcca::relay {

/// Largest payload: 127 octets of the MAC frame without its shortest header (9) and its check
/// sequence (2).
inline constexpr std::size_t kWpanPayload = 127 - 9 - 2;

/// The address in the form of an endpoint, "02:00:00:00:00:00:00:01"; `octets` are in the order in
/// which the address is written.
[[nodiscard]] std::string extended_address(const std::array<std::uint8_t, 8>& octets);
/// The address in the form of an endpoint, "0xbeef:0x0001".
[[nodiscard]] std::string short_address(std::uint16_t pan, std::uint16_t address);

/// The interface between a layer and its radio, which tests replace.
class WpanSocket {
 public:
  /// A received data frame.
  struct Frame {
    std::array<std::uint8_t, kWpanPayload> payload{};
    std::size_t size = 0;  ///< above kWpanPayload: not a valid frame
    std::string from;      ///< address of the sender; empty: the frame has none
    std::uint64_t unix_ns = 0;
  };

  WpanSocket() = default;
  WpanSocket(const WpanSocket&) = delete;
  WpanSocket& operator=(const WpanSocket&) = delete;
  WpanSocket(WpanSocket&&) = delete;
  WpanSocket& operator=(WpanSocket&&) = delete;
  virtual ~WpanSocket() = default;

  [[nodiscard]] virtual int fd() const = 0;
  /// The result of receive(); `gone`: the interface is gone.
  enum class Got : std::uint8_t { frame, nothing, gone };
  virtual Got receive(Frame& to) = 0;
  virtual Sent send(Octets payload) = 0;
  [[nodiscard]] virtual std::uint64_t dropped() const = 0;
};

/// Opens a socket. Fails if the interface has no PAN or no short address, or if the process is not
/// in the initial network namespace, where alone the kernel has such sockets.
[[nodiscard]] Result<std::unique_ptr<WpanSocket>> open_wpan_socket(const std::string& interface);

/// The layer of an IEEE 802.15.4 interface.
class WpanLayer : public Layer {
 public:
  static Result<std::unique_ptr<Layer>> open(const control::Endpoint& endpoint);
  explicit WpanLayer(std::unique_ptr<WpanSocket> socket) : socket_(std::move(socket)) {}

  [[nodiscard]] int fd() const override { return socket_->fd(); }
  [[nodiscard]] Result<void> follow(Follower follower, const control::Endpoint& endpoint,
                                    std::uint64_t subject, std::size_t longest) override;
  void leave(Follower follower, const control::Endpoint& endpoint, std::uint64_t subject) override;
  bool receive(std::size_t most, const OnEvent& on_event) override;
  Sent send(const control::Endpoint& endpoint, std::uint64_t subject, Octets event) override;
  [[nodiscard]] Losses losses() const override;

 private:
  std::unique_ptr<WpanSocket> socket_;
  Followers<std::string> followers_;
  Losses losses_;
};

}  // namespace mlcca::relay
