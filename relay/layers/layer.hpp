// SPDX-License-Identifier: BSD-2-Clause
// The events of one interface: sockets of this process that send them and receive them. The relay
// has a layer for each interface, and so has a program that is linked with libmlcca.
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

/// What became of an event that was sent.
enum class Sent : std::uint8_t {
  sent,      ///< or it waits for its turn, where frames have to be apart
  dropped,   ///< the queue of the interface or of the socket is full, or the gate drops it (CAN)
  too_long,  ///< for the network
  failed,    ///< the interface is gone or down
};

/// What came and gave no event, and what was to be sent later and could not.
struct Losses {
  std::uint64_t malformed = 0;   ///< frames or datagrams that are none of the profile
  std::uint64_t incomplete = 0;  ///< events of several of them, of which one is missing or late
  std::uint64_t crowded = 0;     ///< events that were given up: too many were begun
  std::uint64_t too_long = 0;    ///< longer than the follower takes
  std::uint64_t in_socket = 0;   ///< the process came too late, and its socket was full
  std::uint64_t unsent = 0;      ///< events of which the network did not take a later frame
  [[nodiscard]] std::uint64_t all() const {
    return malformed + incomplete + crowded + too_long + in_socket + unsent;
  }
};

class Layer {
 public:
  /// Who follows a channel, by a number of the caller.
  using Follower = std::uint32_t;
  struct Arrival {
    Follower follower = 0;
    Octets event;               ///< valid until the handler returns
    std::uint64_t unix_ns = 0;  ///< when the kernel received it, or its last frame
    /// Who sent it: on CAN the identifier of that frame, else the IPv4 address in the order of the
    /// host.
    std::uint32_t source = 0;
    std::string_view station{};  ///< the same on IEEE 802.15.4, as an endpoint has its address
  };
  using OnEvent = std::function<void(const Arrival&)>;

  Layer() = default;
  Layer(const Layer&) = delete;
  Layer& operator=(const Layer&) = delete;
  Layer(Layer&&) = delete;
  Layer& operator=(Layer&&) = delete;
  virtual ~Layer() = default;

  /// Can be read when receive() has something to do. It stays the same.
  [[nodiscard]] virtual int fd() const = 0;
  /// Events of the subject that come as the endpoint has them, of at most `longest` bytes. What the
  /// interface itself sends is not received. Error: the profile is not known here, or the process
  /// has no descriptors or memory left.
  [[nodiscard]] virtual Result<void> follow(Follower follower, const control::Endpoint& endpoint,
                                            std::uint64_t subject, std::size_t longest) = 0;
  /// With what follow() was called with. Neither is for a handler of receive().
  virtual void leave(Follower follower, const control::Endpoint& endpoint,
                     std::uint64_t subject) = 0;
  /// Sends what has waited for its time, takes at most `most` frames or datagrams, without waiting,
  /// and hands over the events that they complete. False: the interface is gone.
  virtual bool receive(std::size_t most, const OnEvent& on_event) = 0;
  /// Gives up what was begun and not completed in time, as receive() does where something comes.
  /// Call it once a second while holds_parts(): else what nothing follows would keep its memory.
  virtual void expire() {}
  /// Of events that are not complete.
  [[nodiscard]] virtual bool holds_parts() const { return false; }
  /// Never waits. Frames that have to be apart go later, from receive().
  virtual Sent send(const control::Endpoint& endpoint, std::uint64_t subject, Octets event) = 0;
  [[nodiscard]] virtual Losses losses() const = 0;
};

/// Of the interface that the endpoint is on.
[[nodiscard]] Result<std::unique_ptr<Layer>> open_layer(const control::Endpoint& endpoint);

/// All that open_layer() makes of an endpoint depends on, and what the events of a channel depend
/// on is empty. Where it differs the layer has to be opened again.
[[nodiscard]] control::Endpoint form_of_layer(control::Endpoint endpoint);

/// A layer, and what it was opened for.
struct OpenedLayer {
  control::Endpoint form;
  std::unique_ptr<Layer> layer;
  [[nodiscard]] bool serves(const control::Endpoint& endpoint) const {
    return form == form_of_layer(endpoint);
  }
};

}  // namespace mlcca::relay
