// SPDX-License-Identifier: BSD-2-Clause
// The interface of layers: one layer sends and receives the events of one network interface.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string_view>

#include "base/result.hpp"
#include "control/messages.hpp"

namespace mlcca::relay {

using Octets = std::span<const std::uint8_t>;

/// The result of sending an event.
enum class Sent : std::uint8_t {
  sent,      ///< sent, or waiting for its turn if frames must be spaced
  dropped,   ///< the queue of the interface or the socket is full, or the gate drops it (CAN)
  too_long,  ///< longer than the network carries
  failed,    ///< the interface is gone or down
};

/// Counts of what was received but gave no event, and of what could not be sent later.
struct Losses {
  std::uint64_t malformed = 0;   ///< frames or datagrams that are invalid in the profile
  std::uint64_t incomplete = 0;  ///< events of several frames of which one is missing or late
  std::uint64_t crowded = 0;     ///< events given up because too many were incomplete
  std::uint64_t too_long = 0;    ///< events longer than the follower takes
  std::uint64_t in_socket = 0;   ///< lost because the process read too late and its socket was full
  std::uint64_t unsent = 0;      ///< events of which a delayed frame was not taken by the network
  [[nodiscard]] std::uint64_t all() const {
    return malformed + incomplete + crowded + too_long + in_socket + unsent;
  }
};

/// Sends and receives the events of one interface, with sockets of this process. mlcca-relay and
/// each program that is linked with libmlcca have a layer for each interface.
class Layer {
 public:
  /// A receiver of a channel, by a number that the caller chooses.
  using Follower = std::uint32_t;
  /// An event that was received.
  struct Arrival {
    Follower follower = 0;
    Octets event;               ///< valid until the handler returns
    std::uint64_t unix_ns = 0;  ///< when the kernel received it, or its last frame; 0: unknown
    /// The sender: on CAN the identifier of that frame, otherwise the IPv4 address in host byte
    /// order.
    std::uint32_t source = 0;
    std::string_view station{};  ///< the sender on IEEE 802.15.4, in the form of an endpoint's
                                 ///< address
  };
  using OnEvent = std::function<void(const Arrival&)>;

  Layer() = default;
  Layer(const Layer&) = delete;
  Layer& operator=(const Layer&) = delete;
  Layer(Layer&&) = delete;
  Layer& operator=(Layer&&) = delete;
  virtual ~Layer() = default;

  /// A descriptor that is readable when receive() has work to do. It is the same for the lifetime
  /// of the layer.
  [[nodiscard]] virtual int fd() const = 0;
  /// Receives events of the subject in the form of the endpoint, of at most `longest` bytes. Events
  /// that this interface sends itself are not received. Fails if the profile is not supported, or
  /// if no descriptors or memory are left.
  [[nodiscard]] virtual Result<void> follow(Follower follower, const control::Endpoint& endpoint,
                                            std::uint64_t subject, std::size_t longest) = 0;
  /// Ends follow() with the same arguments. Neither may be called by a handler of receive().
  virtual void leave(Follower follower, const control::Endpoint& endpoint,
                     std::uint64_t subject) = 0;
  /// Sends delayed frames that are due, receives at most `most` frames or datagrams without
  /// waiting, and calls `on_event` for the events that they complete. Returns false if the
  /// interface is gone.
  virtual bool receive(std::size_t most, const OnEvent& on_event) = 0;
  /// Gives up incomplete events that are overdue; receive() does that only when something arrives.
  /// To be called once a second while holds_parts() is true, to free their memory.
  virtual void expire() {}
  /// Whether incomplete events are stored.
  [[nodiscard]] virtual bool holds_parts() const { return false; }
  /// Sends an event without waiting. Frames that must be spaced are sent later by receive().
  virtual Sent send(const control::Endpoint& endpoint, std::uint64_t subject, Octets event) = 0;
  [[nodiscard]] virtual Losses losses() const = 0;
};

/// Opens a layer for the interface of the endpoint.
[[nodiscard]] Result<std::unique_ptr<Layer>> open_layer(const control::Endpoint& endpoint);

/// The part of an endpoint that the layer of its interface depends on; the members that concern one
/// channel are empty. If it changes, the layer has to be opened again.
[[nodiscard]] control::Endpoint form_of_layer(control::Endpoint endpoint);

/// A layer and the endpoint that it was opened for.
struct OpenedLayer {
  control::Endpoint form;
  std::unique_ptr<Layer> layer;
  [[nodiscard]] bool serves(const control::Endpoint& endpoint) const {
    return form == form_of_layer(endpoint);
  }
};

}  // namespace mlcca::relay
