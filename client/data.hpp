// SPDX-License-Identifier: BSD-2-Clause
// The events of a program's channels: sockets of its own on each interface that they are granted
// for, and one of each subscriber for other programs on the gateway. They are opened when they are
// needed.
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
#include "client/local_senders.hpp"
#include "client/local_socket.hpp"
#include "client/local_source.hpp"
#include "client/part.hpp"
#include "mlcca/client/client.hpp"
#include "relay/layers/layer.hpp"

namespace mlcca::client {

class Client::Data {
 public:
  using PartOf = std::shared_ptr<Channel::Part>;
  using Octets = std::span<const std::uint8_t>;

  /// The sockets are added to `epoll`, which must outlive this.
  explicit Data(const Fd& epoll);

  /// Where programs on the gateway send events to this subscriber; empty: there are no descriptors
  /// left. It is another one when a publisher has lost its grant: then it is announced again.
  [[nodiscard]] std::string address(const PartOf& part);
  /// It sends and receives by the endpoints of this answer from now on; of an error there are none.
  /// Error: one cannot be used, and why.
  [[nodiscard]] Result<void> use(const PartOf& part, const control::Reply& reply);
  [[nodiscard]] Published publish(const Channel::Part& part, Octets event);
  /// Takes what has come by one of its descriptors, up to a number of events. False: it is none.
  [[nodiscard]] bool receive(int fd);
  /// Of what was taken.
  void call_handlers();
  /// To events of programs on the gateway, as the daemon reports it of a gate.
  struct Happened {
    PartOf part;
    control::Event event;
  };
  [[nodiscard]] std::vector<Happened> take_happened();
  /// A handler threw, and those behind it were not called yet.
  [[nodiscard]] bool has_waiting() const { return !arrived_.empty(); }
  /// Of all interfaces since it began.
  [[nodiscard]] std::uint64_t lost() const;

 private:
  using Follower = relay::Layer::Follower;
  /// A subscriber and one of its endpoints.
  struct Following {
    std::weak_ptr<Channel::Part> part;
    SharedEndpoint endpoint;
    std::uint64_t subject = 0;
  };

  /// A subscriber and programs of one user on the gateway.
  struct Local {
    std::weak_ptr<Channel::Part> part;
    LocalSource source;
  };

  /// An event that waits for its handler, which may do with channels what it likes.
  struct Arrived {
    std::weak_ptr<Channel::Part> part;
    std::string network;
    std::vector<std::uint8_t> octets;
    std::uint64_t unix_ns = 0;
  };

  [[nodiscard]] bool watch(int fd) const;
  [[nodiscard]] bool holds_parts() const;
  void time_expiry();
  void expire();
  /// Opened where it is not. Error: or it is open for a network of another kind, of which the end
  /// does not know yet.
  Result<relay::Layer*> layer_of(const control::Endpoint& endpoint);
  /// The same, opened again for the network as it is now.
  Result<relay::Layer*> renewed_layer_of(const control::Endpoint& endpoint);
  Result<void> use_endpoint(const PartOf& part, const SharedEndpoint& endpoint);
  Result<void> use_endpoints(const PartOf& part, std::vector<control::Endpoint> stated);
  void leave(const std::weak_ptr<Channel::Part>& part);
  void leave_expired();
  std::vector<Following> close(std::uint32_t ifindex);
  void renew(std::uint32_t ifindex);
  relay::Sent send_to(const control::Endpoint& endpoint, std::uint64_t subject, Octets event);
  [[nodiscard]] bool send_local(const std::string& address, std::uint64_t subject, Octets event);
  void close_unused_senders();
  void share_receiver(const PartOf& part);
  void hold_publishers(const PartOf& part, std::vector<std::string> granted);
  void use_local(const PartOf& part, const std::vector<SharedEndpoint>& endpoints);
  void take_local(const LocalReceiver& receiver, const LocalEvent& event);
  std::size_t receive_local(LocalReceiver& receiver, std::size_t most);
  void supervise();
  void supervise_at(std::uint64_t due, std::uint64_t now);
  void take(const relay::Layer::Arrival& arrival);

  const Fd& epoll_;
  Fd timer_;  ///< for what is begun and not completed
  bool is_timed_ = false;
  Fd supervision_;                   ///< the timer of local deliveries
  std::uint64_t supervised_at_ = 0;  ///< when it is due; 0: never
  /// By their sockets. They are kept while the client exists: the daemon knows their addresses.
  std::map<int, std::shared_ptr<LocalReceiver>> receivers_;
  std::vector<std::uint8_t> buffer_;  ///< of all receivers
  LocalSenders senders_;
  std::map<std::uint32_t, relay::OpenedLayer> layers_;  ///< by interface
  std::uint64_t other_losses_ = 0;  ///< of interfaces that were closed, and of local deliveries
  SharedEndpoints endpoints_;
  std::map<Follower, Following> following_;
  Follower last_ = 0;
  std::vector<Local> locals_;
  std::vector<std::weak_ptr<Channel::Part>> publishers_;  ///< that send to such programs
  std::vector<Arrived> arrived_;
  std::vector<Happened> happened_;
};

}  // namespace mlcca::client
