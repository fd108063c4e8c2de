// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/sources/conversation.hpp"

#include <linux/genetlink.h>
#include <netlink/genl/genl.h>
#include <netlink/netlink.h>
#include <sys/epoll.h>

#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "base/system_error.hpp"

namespace mlcca::net {
namespace {

constexpr int kReadsInATurn = 16;  // of at most 32 KiB each, as the kernel fills them

genl::Octets octets_of(nl_msg* message) {
  const nlmsghdr* const header = nlmsg_hdr(message);
  return std::as_bytes(
      std::span(reinterpret_cast<const char*>(header),  // NOLINT(*-reinterpret-cast)
                header->nlmsg_len));
}

/// The reads that libnl may still make in this turn. By itself it would read a dump to its end in
/// one call.
thread_local int reads_left = 0;

int read_within_turn(nl_sock* socket, sockaddr_nl* from, unsigned char** octets, ucred** who) {
  if (reads_left <= 0) return -NLE_AGAIN;
  --reads_left;
  return nl_recv(socket, from, octets, who);
}

/// The errno at the end of a dump; 0 if there is none.
int error_of_end(nl_msg* message) {
  const nlmsghdr* const header = nlmsg_hdr(message);
  int code = 0;
  if (nlmsg_datalen(header) < static_cast<int>(sizeof code)) return 0;
  std::memcpy(&code, nlmsg_data(header), sizeof code);
  return -code;
}

}  // namespace

void Conversation::FreeRequest::operator()(nl_msg* request) const noexcept { nlmsg_free(request); }
void Conversation::FreeSocket::operator()(nl_sock* socket) const noexcept {
  nl_socket_free(socket);
}

Conversation::~Conversation() = default;

Result<std::unique_ptr<Conversation>> Conversation::open(sd_event* loop, int protocol) {
  std::unique_ptr<Conversation> made(new Conversation);
  made->socket_.reset(nl_socket_alloc());
  nl_sock* const socket = made->socket_.get();
  if (socket == nullptr) return fail("nl_socket_alloc: out of memory");
  int e = nl_connect(socket, protocol);
  if (e >= 0) e = nl_socket_set_nonblocking(socket);
  if (e < 0) return fail(std::string("netlink socket: ") + nl_geterror(e));

  // The callbacks only take notes, because the conversation may not be destroyed within
  // nl_recvmsgs().
  Conversation* const self = made.get();
  nl_cb* const callbacks = nl_socket_get_cb(socket);
  nl_cb_overwrite_recv(callbacks, read_within_turn);
  nl_cb_put(callbacks);
  nl_socket_modify_cb(
      socket, NL_CB_MSG_IN, NL_CB_CUSTOM,
      [](nl_msg*, void* p) noexcept -> int {
        auto& conversation = *static_cast<Conversation*>(p);
        return ++conversation.messages_ <= kMaxMessages ? NL_OK : NL_STOP;
      },
      self);
  nl_socket_modify_cb(
      socket, NL_CB_VALID, NL_CB_CUSTOM,
      [](nl_msg* message, void* p) noexcept -> int {
        auto& conversation = *static_cast<Conversation*>(p);
        if (!conversation.asked_.empty()) conversation.asked_.front().each(octets_of(message));
        return NL_OK;
      },
      self);
  nl_socket_modify_cb(
      socket, NL_CB_FINISH, NL_CB_CUSTOM,
      [](nl_msg* message, void* p) noexcept -> int {
        return static_cast<Conversation*>(p)->note_end(error_of_end(message));
      },
      self);
  nl_socket_modify_cb(
      socket, NL_CB_ACK, NL_CB_CUSTOM,
      [](nl_msg*, void* p) noexcept -> int { return static_cast<Conversation*>(p)->note_end(0); },
      self);
  nl_socket_modify_err_cb(
      socket, NL_CB_CUSTOM,
      [](sockaddr_nl*, nlmsgerr* refused, void* p) noexcept -> int {
        return static_cast<Conversation*>(p)->note_end(-refused->error);
      },
      self);
  nl_socket_modify_cb(
      socket, NL_CB_DUMP_INTR, NL_CB_CUSTOM,
      [](nl_msg*, void* p) noexcept -> int {
        static_cast<Conversation*>(p)->interrupted_ = true;
        return NL_OK;
      },
      self);

  sd_event_source* raw = nullptr;
  const auto on_readable = [](sd_event_source*, int, std::uint32_t, void* p) noexcept {
    static_cast<Conversation*>(p)->receive();
    return 0;
  };
  e = sd_event_add_io(loop, &raw, nl_socket_get_fd(socket), EPOLLIN, on_readable, self);
  made->readable_.reset(raw);
  raw = nullptr;
  const auto on_send_failed = [](sd_event_source*, void* p) noexcept {
    auto& conversation = *static_cast<Conversation*>(p);
    conversation.finish(conversation.error_);
    return 0;
  };
  if (e >= 0) e = sd_event_add_defer(loop, &raw, on_send_failed, self);
  made->send_failed_.reset(raw);
  if (e >= 0) e = sd_event_source_set_enabled(raw, SD_EVENT_OFF);
  if (e < 0) return system_error("netlink socket", -e);
  return made;
}

Conversation::Request Conversation::route_request(std::uint16_t type, int flags) {
  return Request(nlmsg_alloc_simple(type, flags));
}

Conversation::Request Conversation::generic_request(std::uint16_t family, std::uint8_t command,
                                                    int flags) {
  Request request(nlmsg_alloc());
  if (request) genlmsg_put(request.get(), NL_AUTO_PORT, NL_AUTO_SEQ, family, 0, flags, command, 1);
  return request;
}

void Conversation::ask(Request request, OnMessage each, OnEnd end) {
  asked_.push_back({.request = std::move(request), .each = std::move(each), .end = std::move(end)});
  if (asked_.size() == 1) send_first();
}

void Conversation::send_first() {
  ended_ = interrupted_ = false;
  messages_ = 0;
  error_ = 0;
  nl_msg* const request = asked_.front().request.get();
  errno = 0;
  if (request != nullptr && nl_send_auto(socket_.get(), request) >= 0) return;
  // Reported from the loop, like every other end.
  error_ = request == nullptr ? ENOMEM : (errno != 0 ? errno : EIO);
  sd_event_source_set_enabled(send_failed_.get(), SD_EVENT_ONESHOT);
}

int Conversation::note_end(int error) {
  error_ = error;
  ended_ = true;
  return NL_STOP;
}

void Conversation::receive() {
  // Reads even if nothing is requested: what is not read keeps the socket readable, for example the
  // rest of an answer that is too long for one turn.
  if (asked_.empty()) {
    ended_ = false;
    messages_ = 0;
  }
  reads_left = kReadsInATurn;
  while (reads_left > 0 && !ended_) {
    const int e = nl_recvmsgs_default(socket_.get());
    if (ended_ || e == -NLE_AGAIN) break;
    if (e < 0) note_end(EIO);
    if (!ended_ && messages_ > kMaxMessages) note_end(EMSGSIZE);
  }
  if (asked_.empty() || !ended_) return;
  finish(error_ == 0 && interrupted_ ? EINTR : error_);
}

void Conversation::finish(int error) {
  const PendingRequest done = std::move(asked_.front());
  asked_.pop_front();
  if (!asked_.empty()) send_first();
  done.end(error);  // last, because it may destroy this object
}

void Conversation::find_family(const std::string& name, OnFamily found) {
  Request request = generic_request(GENL_ID_CTRL, CTRL_CMD_GETFAMILY, 0);
  if (request) nla_put_string(request.get(), CTRL_ATTR_FAMILY_NAME, name.c_str());
  const auto number = std::make_shared<std::optional<std::uint16_t>>();
  ask(
      std::move(request),
      [number](genl::Octets octets) {
        if (const auto message = genl::read_message(octets))
          *number = message->attributes.u16(CTRL_ATTR_FAMILY_ID);
      },
      [number, name, found = std::move(found)](int error) {
        if (error == 0 && *number) {
          found(**number);
          return;
        }
        found(fail("the kernel has no netlink family " + name + " (module not loaded)"));
      });
}

}  // namespace mlcca::net
