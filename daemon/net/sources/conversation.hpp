// SPDX-License-Identifier: BSD-2-Clause
// Netlink requests that are answered on the event loop, without ever waiting.
#pragma once
#include <systemd/sd-event.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>

#include "base/loop_timer.hpp"
#include "base/result.hpp"
#include "daemon/net/sources/genl.hpp"

struct nl_msg;
struct nl_sock;

namespace mlcca::net {

/// One socket, on which one request follows another.
class Conversation {
 public:
  /// A request under construction (libnl).
  struct FreeRequest {
    void operator()(nl_msg* request) const noexcept;
  };
  using Request = std::unique_ptr<nl_msg, FreeRequest>;
  using OnMessage = std::function<void(genl::Octets)>;
  /// Gets 0, or the errno with which the request ended. EINTR: what was listed changed meanwhile,
  /// so parts may be missing.
  using OnEnd = std::function<void(int error)>;
  using OnFamily = std::function<void(Result<std::uint16_t>)>;

  /// The most messages of one answer. A longer one ends with EMSGSIZE.
  static constexpr std::size_t kMaxMessages = 16384;

  /// `protocol`: NETLINK_GENERIC or NETLINK_ROUTE.
  static Result<std::unique_ptr<Conversation>> open(sd_event* loop, int protocol);
  Conversation(const Conversation&) = delete;
  Conversation& operator=(const Conversation&) = delete;
  Conversation(Conversation&&) = delete;
  Conversation& operator=(Conversation&&) = delete;
  ~Conversation();

  /// An rtnetlink request of this type with nothing after its header. `flags`: 0 or NLM_F_DUMP.
  [[nodiscard]] static Request route_request(std::uint16_t type, int flags);
  /// A request to the generic netlink family with this number.
  [[nodiscard]] static Request generic_request(std::uint16_t family, std::uint8_t command,
                                               int flags);

  /// Sends the request when earlier ones have been answered. `each` gets every message of the
  /// answer, `end` its end; both are called from the loop. `end` may destroy the conversation;
  /// later requests are then never answered.
  void ask(Request request, OnMessage each, OnEnd end);
  /// Looks up the number of a generic netlink family.
  void find_family(const std::string& name, OnFamily found);

 private:
  struct FreeSocket {
    void operator()(nl_sock* socket) const noexcept;
  };
  struct PendingRequest {
    Request request;
    OnMessage each;
    OnEnd end;
  };
  Conversation() = default;
  void send_first();
  int note_end(int error);
  void receive();
  void finish(int error);

  std::unique_ptr<nl_sock, FreeSocket> socket_;
  EventSource readable_;
  EventSource send_failed_;
  std::deque<PendingRequest> asked_;
  int error_ = 0;             ///< of the first request in asked_
  std::size_t messages_ = 0;  ///< number of messages of its answer
  bool interrupted_ = false;  ///< its list changed while it was made
  bool ended_ = false;        ///< its last message has come
};

}  // namespace mlcca::net
