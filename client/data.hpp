// SPDX-License-Identifier: BSD-2-Clause
// The sockets that carry the events of a program's channels.
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/handle.hpp"
#include "client/former_receivers.hpp"
#include "client/local_senders.hpp"
#include "client/local_socket.hpp"
#include "client/local_source.hpp"
#include "client/part.hpp"
#include "mlcca/client/client.hpp"
#include "relay/layers/layer.hpp"

namespace mlcca::client {

/// Sends and receives the events of all channels of a Client. It opens a layer (socket) for each
/// interface that a channel is granted for, and one datagram socket per subscriber for events of
/// other programs on the gateway. Sockets are opened when they are needed.
class Client::Data {
 public:
  using PartOf = std::shared_ptr<Channel::Part>;
  using Octets = std::span<const std::uint8_t>;

  /// Adds the sockets to `epoll`, which must outlive this object.
  explicit Data(const Fd& epoll);

  /// The address to which programs on the gateway send events for this subscriber; empty if no file
  /// descriptors are left. It changes when a publisher loses its grant: then the subscriber has to
  /// be announced again.
  [[nodiscard]] std::string address(const PartOf& part);
  /// Makes the channel send and receive by the endpoints of this reply; an error has none. Fails
  /// with a text if one of them cannot be used; the others are in use nevertheless.
  [[nodiscard]] Result<void> use(const PartOf& part, const control::Reply& reply);
  /// The daemon is gone since `since` (CLOCK_MONOTONIC, ns). The channel's events between programs
  /// on the gateway, which pass no gate, end to be granted after the grace that the daemon has
  /// stated, unless use() gets an answer before. Then take_happened() reports it as `lapsed`.
  void lose_daemon(const PartOf& part, std::uint64_t since);
  /// The daemon stops, or withdraws the channel's deliveries on the gateway: these events are not
  /// granted any more until use() gets an answer.
  void close_local(const PartOf& part);
  [[nodiscard]] Published publish(const PartOf& part, Octets event);
  /// Receives what is pending on `fd`, up to a bounded number of events. Returns false if the
  /// descriptor does not belong to this object.
  [[nodiscard]] bool receive(int fd);
  /// Calls the handlers of the events that receive() has collected. Throws what a handler throws.
  void call_handlers();
  /// Something that happened to events of programs on the gateway, as an event like those that the
  /// daemon reports for a gate.
  struct Happened {
    PartOf part;
    control::Event event;
  };
  [[nodiscard]] std::vector<Happened> take_happened();
  /// Whether events wait for call_handlers(), because a handler threw before their turn.
  [[nodiscard]] bool has_waiting() const { return !arrived_.empty(); }
  /// Losses of all interfaces and local deliveries since this object was made.
  [[nodiscard]] std::uint64_t lost() const;
  /// Losses of a subscriber: of programs on the gateway those of its own channel; of the interfaces
  /// from which it receives all of them while it does, since they may be of any channel there.
  [[nodiscard]] std::uint64_t lost(const PartOf& part) const;

 private:
  using Follower = relay::Layer::Follower;
  /// A subscriber and one endpoint that it receives from.
  struct Following {
    std::weak_ptr<Channel::Part> part;
    SharedEndpoint endpoint;
    std::uint64_t subject = 0;
    std::uint64_t lost_before = 0;  ///< losses of the interface when the channel began to receive
  };

  /// A subscriber and the programs of one user on the gateway that it receives from.
  struct Local {
    std::weak_ptr<Channel::Part> part;
    LocalSource source;
  };

  /// What became of an event at one endpoint.
  enum class Passed : std::uint8_t {
    sent,
    lost,
    too_long,
    not_granted,
    gone,  ///< nothing receives at this local endpoint any more
  };

  /// An event that waits for its handler. It is a copy, because handlers may destroy channels and
  /// close sockets.
  struct Arrived {
    std::weak_ptr<Channel::Part> part;
    std::string network;
    std::vector<std::uint8_t> octets;
    std::uint64_t unix_ns = 0;
  };

  /// The grace (ns) of a daemon that states none: the default of mlccad.
  static constexpr std::uint64_t kGrace = 10'000'000'000;

  [[nodiscard]] bool watch(int fd) const;
  [[nodiscard]] bool holds_parts() const;
  void time_expiry();
  void expire();
  /// Returns the layer of the endpoint's interface and opens it if it is not open. Fails as well if
  /// it is open for a network of another kind: then the endpoint is outdated.
  Result<relay::Layer*> layer_of(const control::Endpoint& endpoint);
  /// As layer_of(), but a layer of another kind is closed and opened again for the present network.
  Result<relay::Layer*> renewed_layer_of(const control::Endpoint& endpoint);
  Result<void> use_endpoint(const PartOf& part, const SharedEndpoint& endpoint);
  Result<void> use_endpoints(const PartOf& part, std::vector<control::Endpoint> stated);
  /// What interfaces have lost since the channel receives from them.
  [[nodiscard]] std::uint64_t lost_on_networks(const std::weak_ptr<Channel::Part>& part,
                                               std::optional<std::uint32_t> only = {}) const;
  void leave(const std::weak_ptr<Channel::Part>& part);
  void leave_expired();
  std::vector<Following> close(std::uint32_t ifindex);
  void renew(std::uint32_t ifindex);
  Passed send_to(const PartOf& part, const SharedEndpoint& endpoint, Octets event);
  Passed send_local(const PartOf& part, const SharedEndpoint& endpoint, Octets event);
  std::optional<Passed> withhold(const PartOf& part, const SharedEndpoint& endpoint,
                                 LocalReceiver* own);
  [[nodiscard]] LocalReceiver* own_at(const std::string& address);
  void keep_former(const PartOf& part, std::vector<SharedEndpoint>& endpoints);
  Result<void> close_unused_senders();
  void share_receiver(const PartOf& part);
  void hold_publishers(const PartOf& part, std::vector<std::string> granted);
  void use_local(const PartOf& part, const std::vector<SharedEndpoint>& endpoints);
  void take_local(const LocalReceiver& receiver, const LocalEvent& event);
  std::size_t receive_local(LocalReceiver& receiver, std::size_t most);
  void supervise();
  void report_lapses(std::uint64_t now);
  void supervise_at(std::uint64_t due, std::uint64_t now);
  void take(const relay::Layer::Arrival& arrival);

  const Fd& epoll_;
  Fd timer_;  ///< expires incomplete events of several fragments
  bool is_timed_ = false;
  Fd supervision_;                   ///< the timer for the supervision of local deliveries
  std::uint64_t supervised_at_ = 0;  ///< when it expires, CLOCK_MONOTONIC in ns; 0: it is not set
  /// The receivers by their descriptors. They stay open as long as the client exists, because the
  /// daemon knows their addresses.
  std::map<int, std::shared_ptr<LocalReceiver>> receivers_;
  std::string why_no_receiver_ = "no socket";  ///< why the latest one could not be opened
  std::vector<std::uint8_t> buffer_;           ///< receive buffer, shared by all receivers
  LocalSenders senders_;
  std::map<std::uint32_t, relay::OpenedLayer> layers_;  ///< by interface index
  std::uint64_t other_losses_ = 0;  ///< losses of layers that were closed, and of local deliveries
  SharedEndpoints endpoints_;
  std::map<Follower, Following> following_;
  Follower last_ = 0;
  std::vector<Local> locals_;
  std::vector<std::weak_ptr<Channel::Part>> publishers_;  ///< publishers with subscribers among the
                                                          ///< programs on this gateway
  FormerReceivers former_receivers_;
  std::uint64_t grace_ns_ = kGrace;                   ///< stated by the daemon
  std::vector<std::weak_ptr<Channel::Part>> lapses_;  ///< channels that are granted until the grace
                                                      ///< is over
  std::vector<Arrived> arrived_;
  std::vector<Happened> happened_;
};

}  // namespace mlcca::client
