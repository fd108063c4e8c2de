// SPDX-License-Identifier: BSD-2-Clause
#include "client/local_socket.hpp"

#include <linux/filter.h>
#include <sys/random.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <string>
#include <utility>

#include "base/big_endian.hpp"
#include "base/system_error.hpp"
#include "base/unix_address.hpp"
#include "relay/layers/sockets.hpp"

namespace mlcca::client {
namespace {

constexpr std::size_t kKey = sizeof(std::uint64_t);

Result<std::uint64_t> random_key() {
  std::uint64_t key = 0;
  if (::getrandom(&key, sizeof key, 0) != sizeof key) return system_error("getrandom");
  return key;
}

/// Makes the kernel drop each datagram that does not begin with the key, before it searches for
/// room in the queue. All bits of the key are compared in one operation, so that the duration of a
/// sendto() reveals nothing about a part of it.
Result<void> accept_only(const Fd& socket, std::uint64_t key) {
  constexpr unsigned half = 32;
  const auto high = static_cast<std::uint32_t>(key >> half);
  const auto low = static_cast<std::uint32_t>(key);
  constexpr std::uint32_t all = ~std::uint32_t{0};
  std::array program{
      sock_filter BPF_STMT(BPF_LD | BPF_W | BPF_ABS, 0),  // a shorter datagram ends the program
                                                          // here and is dropped
      sock_filter BPF_STMT(BPF_ALU | BPF_XOR | BPF_K, high),
      sock_filter BPF_STMT(BPF_MISC | BPF_TAX, 0),
      sock_filter BPF_STMT(BPF_LD | BPF_W | BPF_ABS, sizeof high),
      sock_filter BPF_STMT(BPF_ALU | BPF_XOR | BPF_K, low),
      sock_filter BPF_STMT(BPF_ALU | BPF_OR | BPF_X, 0),
      sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, 0, 0, 1),
      sock_filter BPF_STMT(BPF_RET | BPF_K, all),
      sock_filter BPF_STMT(BPF_RET | BPF_K, 0),
  };
  const sock_fprog filter{.len = program.size(), .filter = program.data()};
  if (::setsockopt(socket.get(), SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter) != 0)
    return system_error("SO_ATTACH_FILTER");
  return {};
}

std::unexpected<Error> no_socket(int error) {
  auto why = system_error("socket", error);
  rlimit most{};
  if (error != EMFILE || ::getrlimit(RLIMIT_NOFILE, &most) != 0) return why;
  return fail(why.error().text +
              " (each subscribed channel takes a file descriptor, and this process may have " +
              std::to_string(most.rlim_cur) + ")");
}

/// The user that sent a message; -1 if the kernel does not state it.
uid_t sender_of(msghdr& message) {
  for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr;
       part = CMSG_NXTHDR(&message, part)) {
    if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_CREDENTIALS) continue;
    ucred who{};
    std::memcpy(&who, CMSG_DATA(part), sizeof who);
    return who.uid;
  }
  return static_cast<uid_t>(-1);
}

/// The result for an event that was not sent, by errno.
LocalSender::Sent why_not() {
  const bool gone = errno == ECONNREFUSED || errno == ENOTCONN || errno == EPIPE;
  return gone ? LocalSender::Sent::gone : LocalSender::Sent::full;
}

struct Address {
  sockaddr_un name{};
  socklen_t size = 0;
};

Address address_of(const std::string& name) {
  Address address;
  address.name.sun_family = AF_UNIX;
  name.copy(&address.name.sun_path[1], name.size());
  address.size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  return address;
}

/// The header in front of an event.
struct Header {
  std::uint64_t key = 0;
  std::uint64_t subject = 0;
  LocalCount count;
};

/// Sends one datagram. `to`: the destination; null if the socket is connected.
ssize_t send_event(const Fd& socket, const Header& header, std::span<const std::uint8_t> event,
                   Address* to) {
  constexpr unsigned half = 32;
  auto first = big_endian(header.key);
  auto second = big_endian(header.subject);
  auto third = big_endian(std::uint64_t{header.count.sender} << half | header.count.next);
  // sendmsg() only reads the buffers, so that the const_cast below is safe.
  std::array<iovec, 4> data{
      iovec{.iov_base = first.data(), .iov_len = first.size()},
      iovec{.iov_base = second.data(), .iov_len = second.size()},
      iovec{.iov_base = third.data(), .iov_len = third.size()},
      iovec{.iov_base = const_cast<std::uint8_t*>(event.data()),  // NOLINT(*-const-cast)
            .iov_len = event.size()}};
  msghdr message{};
  if (to != nullptr) {
    message.msg_name = &to->name;
    message.msg_namelen = to->size;
  }
  message.msg_iov = data.data();
  message.msg_iovlen = data.size();
  return ::sendmsg(socket.get(), &message, MSG_DONTWAIT | MSG_NOSIGNAL);
}

}  // namespace

Result<LocalReceiver> LocalReceiver::open() {
  Fd socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket) return no_socket(errno);
  const int on = 1;
  for (const int option : {SO_PASSCRED, SO_TIMESTAMPNS})
    if (::setsockopt(socket.get(), SOL_SOCKET, option, &on, sizeof on) != 0)
      return system_error("setsockopt");
  const auto key = random_key();
  if (!key) return std::unexpected(key.error());
  // The filter is set before the socket has a name that others can send to.
  if (const auto done = accept_only(socket, *key); !done) return std::unexpected(done.error());
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (::bind(socket.get(), generic(address), sizeof address.sun_family) != 0)
    return system_error("bind");
  socklen_t size = sizeof address;
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  if (::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&address), &size) != 0)
    return system_error("getsockname");
  const std::size_t before = offsetof(sockaddr_un, sun_path) + 1;  // up to and including the null
                                                                   // byte
  if (size <= before) return fail("the kernel gave no address to a socket");
  const auto count = LocalCount::begin();
  if (!count) return std::unexpected(count.error());
  return LocalReceiver(std::move(socket),
                       {.name = std::string(&address.sun_path[1], size - before), .key = *key},
                       *count);
}

LocalEvent LocalReceiver::read(Octets datagram, uid_t from, std::uint64_t unix_ns) {
  constexpr unsigned half = 32;
  const std::uint64_t count = from_big_endian(datagram.subspan(2 * kKey, kKey));
  const auto sender = static_cast<std::uint32_t>(count >> half);
  const bool is_notice = (sender & LocalCount::kNotice) != 0;
  return {.subject = from_big_endian(datagram.subspan(kKey, kKey)),
          .from = from,
          .unix_ns = unix_ns,
          .missed = numbers_.missed(from, sender & ~LocalCount::kNotice,
                                    static_cast<std::uint32_t>(count), is_notice),
          .is_notice = is_notice,
          .octets = datagram.subspan(kHeader)};
}

std::size_t LocalReceiver::receive(std::size_t most, Buffer buffer, const OnEvent& on_event) {
  for (std::size_t count = 0; count < most; ++count) {
    iovec data{.iov_base = buffer.data(), .iov_len = buffer.size()};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(ucred)) + CMSG_SPACE(sizeof(timespec))>
        control{};
    msghdr message{};
    message.msg_iov = &data;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t n = ::recvmsg(socket_.get(), &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
    if (n < 0) return count;
    const auto bytes = static_cast<std::size_t>(n);
    if (bytes < kHeader || (message.msg_flags & MSG_TRUNC) != 0) continue;
    const Octets all(buffer.data(), bytes);
    on_event(read(all, sender_of(message), relay::beside(message).unix_ns));
  }
  return most;
}

bool LocalReceiver::send_to_itself(std::uint64_t subject, Octets event) {
  Address address = address_of(own_.name);
  const bool sent = send_event(socket_, {.key = own_.key, .subject = subject, .count = to_itself_},
                               event, &address) >= 0;
  ++to_itself_.next;
  return sent;
}

void LocalReceiver::change_key() {
  const auto key = random_key();
  if (key && accept_only(socket_, *key)) {
    own_.key = *key;
    address_ = control::to_text(own_);
    return;
  }
  socket_.reset();
  address_.clear();
}

Result<LocalSender> LocalSender::to(const control::LocalAddress& to) {
  const auto count = LocalCount::begin();
  if (!count) return std::unexpected(count.error());
  return LocalSender(to, *count);
}

Result<LocalSender> LocalSender::open(const control::LocalAddress& to) {
  auto sender = LocalSender::to(to);
  if (!sender) return sender;
  if (const auto opened = sender->open(); !opened) return std::unexpected(opened.error());
  return sender;
}

Result<void> LocalSender::open() {
  Fd socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket) return system_error("socket");
  const Address receiver = address_of(to_.name);
  if (::connect(socket.get(), generic(receiver.name), receiver.size) != 0) {
    // EPROTOTYPE: a socket of another kind has the name, which receives no datagrams either.
    is_gone_ = errno == ECONNREFUSED || errno == EPROTOTYPE;
    return system_error("connect");
  }
  socket_ = std::move(socket);
  return {};
}

LocalSender::Sent LocalSender::lose(std::uint64_t subject) {
  subject_ = subject;
  ++count_.next;
  return is_gone_ ? Sent::gone : Sent::full;
}

LocalSender::Sent LocalSender::send(std::uint64_t subject, Octets event) {
  subject_ = subject;
  const bool sent = send_event(socket_, {.key = to_.key, .subject = subject, .count = count_},
                               event, nullptr) >= 0;
  const Sent how = sent ? Sent::sent : why_not();
  ++count_.next;
  return how;
}

LocalSender::Sent LocalSender::send_notice() {
  LocalCount count = count_;
  count.sender |= LocalCount::kNotice;
  const bool sent =
      send_event(socket_, {.key = to_.key, .subject = subject_, .count = count}, {}, nullptr) >= 0;
  return sent ? Sent::sent : why_not();
}

}  // namespace mlcca::client
