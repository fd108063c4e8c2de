// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/rtnl.hpp"

#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <netlink/attr.h>
#include <netlink/msg.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <new>
#include <optional>
#include <utility>

namespace mlcca::net {
namespace {

constexpr std::size_t kFirstBuffer = std::size_t{64} << 10;
constexpr const char* kTooLate = "the kernel has not answered in time";
constexpr std::size_t kMostBuffer = std::size_t{4} << 20;  // bytes of one datagram

constexpr int kMostErrno = 4095;

std::string text_of(int error) { return std::strerror(error); }  // NOLINT(concurrency-mt-unsafe)

/// The result in a message that ends an answer: 0 or an errno; nullopt if it has none.
std::optional<int> verdict_of(const nlmsghdr& message) {
  int error = 0;
  if (message.nlmsg_len < NLMSG_LENGTH(sizeof error)) return std::nullopt;
  std::memcpy(&error, nlmsg_data(&message), sizeof error);
  if (error < -kMostErrno) return std::nullopt;
  return error < 0 ? -error : 0;
}

}  // namespace

void FreeMessage::operator()(nl_msg* message) const noexcept { nlmsg_free(message); }

Message new_message(int type, int flags, const void* head, std::size_t size) {
  Message message(nlmsg_alloc_simple(type, flags));
  if (!message || nlmsg_append(message.get(), const_cast<void*>(head), size, NLMSG_ALIGNTO) != 0)
    throw std::bad_alloc();
  return message;
}

std::string text_in(const nlattr& attribute) {
  const auto* text = static_cast<const char*>(nla_data(&attribute));
  return {text, ::strnlen(text, static_cast<std::size_t>(nla_len(&attribute)))};
}

std::uint32_t number_in(const nlattr& attribute) {
  std::uint32_t number = 0;
  if (nla_len(&attribute) >= static_cast<int>(sizeof number))
    std::memcpy(&number, nla_data(&attribute), sizeof number);
  return number;
}

std::unexpected<Error> Refusal::when(const std::string& doing) const {
  return fail(doing + ": " + text);
}

void Answers::add(const nlmsghdr& message) {
  // NOLINTNEXTLINE(*-reinterpret-cast): octets are what it is made of
  const auto* octets = reinterpret_cast<const char*>(&message);
  octets_.insert(octets_.end(), octets, octets + message.nlmsg_len);
  octets_.resize(NLMSG_ALIGN(octets_.size()));
}

namespace {

/// Whether a CAN link has no data. libnl would read the data without checking whether the kernel
/// has reported it. Of two attributes of one type libnl uses the last one, and so does this
/// function.
bool is_can_without_data(nlmsghdr* link) {
  std::array<nlattr*, IFLA_MAX + 1> all{};
  std::array<nlattr*, IFLA_INFO_MAX + 1> info{};
  if (nlmsg_parse(link, sizeof(ifinfomsg), all.data(), IFLA_MAX, nullptr) < 0 ||
      all[IFLA_LINKINFO] == nullptr ||
      nla_parse_nested(info.data(), IFLA_INFO_MAX, all[IFLA_LINKINFO], nullptr) < 0)
    return false;
  return info[IFLA_INFO_KIND] != nullptr && nla_strcmp(info[IFLA_INFO_KIND], "can") == 0 &&
         info[IFLA_INFO_DATA] == nullptr;
}

bool has_options(const Message& discipline) {
  return nlmsg_find_attr(nlmsg_hdr(discipline.get()), sizeof(tcmsg), TCA_OPTIONS) != nullptr;
}

/// Adds empty options to a discipline without options, because libnl reads the options of some
/// disciplines without checking whether they exist. False if libnl would not find the added ones,
/// after something that cannot be read.
bool give_options(const Message& discipline) {
  if (has_options(discipline)) return true;
  const std::size_t size = nlmsg_hdr(discipline.get())->nlmsg_len;
  return nlmsg_expand(discipline.get(), NLMSG_ALIGN(size) + NLA_HDRLEN) == 0 &&
         nla_put(discipline.get(), TCA_OPTIONS, 0, nullptr) == 0 && has_options(discipline);
}

}  // namespace

void Answers::parse(const nlmsghdr& message, void (*take)(nl_object*, void*), void* to) {
  const Message copy(nlmsg_convert(const_cast<nlmsghdr*>(&message)));  // NOLINT(*-const-cast)
  if (!copy) throw std::bad_alloc();
  nlmsg_set_proto(copy.get(), NETLINK_ROUTE);
  if (message.nlmsg_type == RTM_NEWLINK && is_can_without_data(nlmsg_hdr(copy.get()))) return;
  if (message.nlmsg_type == RTM_NEWQDISC && !give_options(copy)) return;
  nl_msg_parse(copy.get(), take, to);
}

std::unexpected<Refusal> Rtnl::give_up(std::string why) {
  if (socket_) ++replaced_;
  socket_.reset();
  return std::unexpected(Refusal{0, std::move(why)});
}

std::unexpected<Refusal> Rtnl::give_up(const char* call, int error) {
  return give_up(std::string(call) + ": " + text_of(error));
}

std::expected<Answers, Refusal> Rtnl::dump(const Message& request) {
  return ask_again(request, NLM_F_DUMP);
}

std::expected<Answers, Refusal> Rtnl::get(const Message& request) {
  return ask_again(request, NLM_F_ACK);
}

std::expected<void, Refusal> Rtnl::change(const Message& request) {
  Answers none;
  const auto done = ask_once(request, NLM_F_ACK, std::chrono::steady_clock::now() + kLimit, none);
  if (!done) return std::unexpected(done.error());
  return {};
}

std::expected<Answers, Refusal> Rtnl::ask_again(const Message& request, unsigned flags) {
  const Time end = std::chrono::steady_clock::now() + kLimit;
  Refusal last{0, "it changed again and again while it was read"};
  for (int i = 0; i < kTries && std::chrono::steady_clock::now() < end; ++i) {
    Answers answers;
    auto done = ask_once(request, flags, end, answers);
    if (done && *done == Ending::done) return answers;
    if (done) continue;
    if (done.error().said != 0) return std::unexpected(std::move(done.error()));
    last = std::move(done.error());
  }
  return std::unexpected(std::move(last));
}

struct Rtnl::Read {
  bool is_list;
  Answers& to;
  bool interrupted = false;
};

std::expected<Rtnl::Ending, Refusal> Rtnl::ask_once(const Message& request, unsigned flags,
                                                    Time end, Answers& to) {
  if (auto sent = send(request, flags); !sent) return std::unexpected(std::move(sent.error()));
  Read read{.is_list = (flags & NLM_F_DUMP) != 0, .to = to};
  for (unsigned late = 0;;) {
    const auto size = receive(end, late);
    if (!size) return std::unexpected(size.error());
    // NOLINTBEGIN(*-cstyle-cast,*-reinterpret-cast): macros of the kernel's header
    auto left = static_cast<int>(*size);
    const auto* message = reinterpret_cast<const nlmsghdr*>(buffer_.data());
    for (; NLMSG_OK(message, left); message = NLMSG_NEXT(message, left)) {
      // NOLINTEND(*-cstyle-cast,*-reinterpret-cast)
      const auto ended = take(*message, read);
      if (!ended) return std::unexpected(ended.error());
      if (*ended) return read.interrupted ? Ending::again : Ending::done;
    }
    if (left > 0) return give_up("an answer that is torn");
  }
}

std::expected<void, Refusal> Rtnl::send(const Message& request, unsigned flags) {
  if (!socket_) socket_.reset(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE));
  if (!socket_) return give_up("rtnetlink socket", errno);
  nlmsghdr* const head = nlmsg_hdr(request.get());
  head->nlmsg_flags = static_cast<std::uint16_t>(head->nlmsg_flags | NLM_F_REQUEST | flags);
  head->nlmsg_seq = ++sequence_;
  head->nlmsg_pid = 0;
  const ssize_t sent = ::send(socket_.get(), head, head->nlmsg_len, MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent < 0) return give_up("asking rtnetlink", errno);
  if (sent != static_cast<ssize_t>(head->nlmsg_len)) return give_up("half a question was sent");
  return {};
}

/// Takes one message; true if it was the last one.
std::expected<bool, Refusal> Rtnl::take(const nlmsghdr& message, Read& read) {
  if (message.nlmsg_seq != sequence_) return give_up("an answer to another question");
  read.interrupted = read.interrupted || (message.nlmsg_flags & NLM_F_DUMP_INTR) != 0;
  const int type = message.nlmsg_type;
  if (type == NLMSG_NOOP) return false;
  if (type != NLMSG_DONE && type != NLMSG_ERROR) {
    if (type == NLMSG_OVERRUN || read.to.size() > kMostOctets)
      return give_up("more than there is room for");
    read.to.add(message);
    return false;
  }
  const auto said = verdict_of(message);
  if (!said) return give_up("an answer without an end");
  if (*said != 0) return std::unexpected(Refusal{*said, text_of(*said)});
  // A list ends with NLMSG_DONE; everything else is acknowledged.
  if (read.is_list != (type == NLMSG_DONE)) return give_up("the answer ended too early");
  return true;
}

std::expected<std::size_t, Refusal> Rtnl::receive(Time end, unsigned& late) {
  buffer_.resize(std::max(buffer_.size(), kFirstBuffer));
  for (;;) {
    sockaddr_nl sender{};
    iovec room{buffer_.data(), buffer_.size()};
    msghdr datagram{};
    datagram.msg_name = &sender;
    datagram.msg_namelen = sizeof sender;
    datagram.msg_iov = &room;
    datagram.msg_iovlen = 1;
    // Datagrams that are there are read first, however late this process is.
    const ssize_t size = ::recvmsg(socket_.get(), &datagram, MSG_DONTWAIT);
    if (size == 0) return give_up("rtnetlink has hung up");
    if (size < 0) {
      if (auto waited = wait(errno, end); !waited) return std::unexpected(waited.error());
      continue;
    }
    if ((datagram.msg_flags & MSG_TRUNC) != 0) {
      buffer_.resize(std::min(buffer_.size() * 4, kMostBuffer));
      return give_up("an answer is longer than the room for it");
    }
    const bool from_kernel = sender.nl_pid == 0;
    // An unlimited sequence of answers must not extend the limit, and messages of other processes
    // not at all.
    const bool in_time = std::chrono::steady_clock::now() < end;
    if (!in_time && (!from_kernel || ++late > kMostLate)) return give_up(kTooLate);
    if (from_kernel) return static_cast<std::size_t>(size);
  }
}

/// Waits until something comes, after nothing was there.
std::expected<void, Refusal> Rtnl::wait(int error, Time end) {
  if (error != EAGAIN && error != EINTR) return give_up("receiving from rtnetlink", error);
  const auto left = std::max(
      std::chrono::milliseconds(0),
      std::chrono::ceil<std::chrono::milliseconds>(end - std::chrono::steady_clock::now()));
  pollfd waits{socket_.get(), POLLIN, 0};
  const int ready = ::poll(&waits, 1, static_cast<int>(left.count()));
  if (ready == 0) return give_up(kTooLate);
  if (ready < 0 && errno != EINTR) return give_up("waiting for rtnetlink", errno);
  return {};
}

}  // namespace mlcca::net
