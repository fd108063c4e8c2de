// SPDX-License-Identifier: BSD-2-Clause
// Any octets as what rtnetlink and generic netlink say. The first octet: who asks (its low bits),
// and whether what comes starts again when it ends; then pieces, a datagram each. The first octet
// of one says what becomes of it on its way, see Fate. No call waits without end, a read that fails
// changes nothing, and only what the kernel reported as gone has gone.
#include <linux/genetlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <netlink/netlink.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <systemd/sd-event.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/net/can_controller.hpp"
#include "daemon/net/can_routes.hpp"
#include "daemon/net/filter_order.hpp"
#include "daemon/net/links.hpp"
#include "daemon/net/queue.hpp"
#include "daemon/net/sources/conversation.hpp"
#include "daemon/net/sources/wire.hpp"
#include "tests/fuzz/sources_check.hpp"

namespace {

using namespace mlcca;
using fuzz::demand;

constexpr int kAsked = 7;                   // interface
constexpr std::uint64_t kStep = 1'000'000;  // ns that one call takes
/// More calls than any limit of time or octets admits.
constexpr std::size_t kMostCalls = 2'000'000;

enum Fate : unsigned char {
  notice = 1,     // unasked, not an answer
  foreign = 2,    // not from the kernel
  truncated = 4,  // longer than the room
  other_question = 8,
  fails = 16,  // an errno in its place: the first octet behind this one
};

struct Datagram {
  unsigned char fate = 0;
  std::vector<char> octets;
};

/// The kernel as the input states it, in place of the real one while a caller asks.
struct Kernel {
  bool answers_now = false;
  bool endless = false;
  std::vector<Datagram> answers;
  std::vector<Datagram> notices;
  std::size_t next_answer = 0;
  std::size_t next_notice = 0;
  std::uint32_t question = 0;
  std::uint64_t now = 1'000'000'000;
  std::size_t calls = 0;
  bool said_no_device = false;  // to the latest question
  std::set<int> said_gone;

  const Datagram* next(std::vector<Datagram>& of, std::size_t& at, bool again) const {
    if (at == of.size() && again) at = 0;
    return at == of.size() ? nullptr : &of[at++];
  }
};
Kernel kernel;

template <class Take>
void each_message(char* octets, std::size_t size, Take&& take) {
  for (std::size_t at = 0; at + sizeof(nlmsghdr) <= size;) {
    nlmsghdr head{};
    std::memcpy(&head, octets + at, sizeof head);
    if (head.nlmsg_len < sizeof head || head.nlmsg_len > size - at) return;
    take(head, octets + at);
    at += NLMSG_ALIGN(head.nlmsg_len);
  }
}

/// What the kernel has sent is interpreted here independently, so that no caller is believed
/// without a message for it.
ssize_t receive(const Datagram* said, msghdr* message) {
  demand(++kernel.calls < kMostCalls);
  kernel.now += kStep;
  if (said == nullptr) return errno = EAGAIN, -1;
  if ((said->fate & Fate::fails) != 0) {
    errno = said->octets.empty() ? ENOBUFS : 1 + static_cast<unsigned char>(said->octets[0]) % 120;
    return -1;
  }
  std::vector<char> octets = said->octets;
  each_message(octets.data(), octets.size(), [&](nlmsghdr head, char* at) {
    if ((said->fate & (Fate::other_question | Fate::notice)) == 0) head.nlmsg_seq = kernel.question;
    std::memcpy(at, &head, sizeof head);
    const std::size_t size = head.nlmsg_len - sizeof head;
    const char* const body = at + sizeof head;
    if ((said->fate & Fate::foreign) != 0) return;
    int number = 0;
    if (head.nlmsg_type == NLMSG_ERROR && size >= sizeof number) {
      std::memcpy(&number, body, sizeof number);
      if (number == -ENODEV) kernel.said_no_device = true;
    }
    ifinfomsg info{};
    if (head.nlmsg_type == RTM_DELLINK && size >= sizeof info) {
      std::memcpy(&info, body, sizeof info);
      kernel.said_gone.insert(info.ifi_index);
    }
  });
  if (message->msg_name != nullptr) {
    sockaddr_nl from{};
    from.nl_family = AF_NETLINK;
    from.nl_pid = (said->fate & Fate::foreign) != 0 ? 4711 : 0;
    std::memcpy(message->msg_name, &from, std::min<std::size_t>(message->msg_namelen, sizeof from));
    message->msg_namelen = sizeof from;
  }
  const std::size_t room = message->msg_iov[0].iov_len;
  const std::size_t taken = std::min(room, octets.size());
  if (taken != 0) std::memcpy(message->msg_iov[0].iov_base, octets.data(), taken);
  message->msg_controllen = 0;
  message->msg_flags = taken < octets.size() || (said->fate & Fate::truncated) != 0 ? MSG_TRUNC : 0;
  return static_cast<ssize_t>(taken);
}

void take_question(const void* octets, std::size_t size) {
  nlmsghdr head{};
  if (size < sizeof head) return;
  std::memcpy(&head, octets, sizeof head);
  kernel.question = head.nlmsg_seq;
  kernel.said_no_device = false;
}

}  // namespace

// NOLINTBEGIN(*-vararg)
extern "C" ssize_t recvmsg(int fd, msghdr* message, int flags) {
  if (!kernel.answers_now) return ::syscall(SYS_recvmsg, fd, message, flags);
  return receive(kernel.next(kernel.answers, kernel.next_answer, kernel.endless), message);
}
extern "C" ssize_t recvfrom(int fd, void* octets, size_t size, int flags, sockaddr* from,
                            socklen_t* length) {
  if (!kernel.answers_now) return ::syscall(SYS_recvfrom, fd, octets, size, flags, from, length);
  iovec room{octets, size};
  msghdr message{};
  message.msg_name = from;
  message.msg_namelen = length == nullptr ? 0 : *length;
  message.msg_iov = &room;
  message.msg_iovlen = 1;
  const ssize_t taken = receive(kernel.next(kernel.notices, kernel.next_notice, false), &message);
  if (taken < 0 || (flags & MSG_TRUNC) == 0 || (message.msg_flags & MSG_TRUNC) == 0) return taken;
  return static_cast<ssize_t>(size) + 1;
}
extern "C" ssize_t send(int fd, const void* octets, size_t size, int flags) {
  if (!kernel.answers_now) return ::syscall(SYS_sendto, fd, octets, size, flags, nullptr, 0);
  take_question(octets, size);
  return static_cast<ssize_t>(size);
}
/// Of libnl. The real kernel answers as well, which makes the socket readable.
extern "C" ssize_t sendmsg(int fd, const msghdr* message, int flags) {
  if (kernel.answers_now && message->msg_iovlen > 0)
    take_question(message->msg_iov[0].iov_base, message->msg_iov[0].iov_len);
  return ::syscall(SYS_sendmsg, fd, message, flags);
}
extern "C" int poll(pollfd* fds, nfds_t count, int timeout) {
  if (!kernel.answers_now) return static_cast<int>(::syscall(SYS_poll, fds, count, timeout));
  demand(timeout >= 0);
  if (kernel.endless && !kernel.answers.empty()) return 1;
  kernel.now += static_cast<std::uint64_t>(timeout) * kStep;
  return 0;
}
extern "C" int clock_gettime(clockid_t clock, timespec* to) noexcept {
  if (!kernel.answers_now || clock != CLOCK_MONOTONIC)
    return static_cast<int>(::syscall(SYS_clock_gettime, clock, to));
  to->tv_sec = static_cast<time_t>(kernel.now / 1'000'000'000);
  to->tv_nsec = static_cast<long>(kernel.now % 1'000'000'000);
  return 0;
}
// NOLINTEND(*-vararg)

namespace {

void links() {
  kernel.answers_now = false;
  auto opened = net::Links::open();
  demand(opened.has_value());
  kernel.answers_now = true;
  std::set<int> gone;
  for (int i = 0; i < 3; ++i) {
    const net::InterfaceTable before = opened->table();
    const auto read = opened->refresh();
    demand(read.has_value() == opened->problem().empty());
    if (!read) demand(opened->table() == before);
    for (const auto& [ifindex, link] : opened->table()) demand(ifindex == link.ifindex);
    for (const int ifindex : opened->take_gone()) demand(kernel.said_gone.contains(ifindex));
    for (const auto& moved : opened->take_moved()) demand(kernel.said_gone.contains(moved.ifindex));
    if (opened->presence(kAsked) == net::Presence::gone) demand(kernel.said_no_device);
    static_cast<void>(opened->traffic(kAsked));
    static_cast<void>(opened->take_tc_changed());
    kernel.said_gone.clear();
  }
  static_cast<void>(opened->set_bitrates(kAsked, 500'000, 2'000'000));
  static_cast<void>(opened->set_up(kAsked, true));
}

void queues() {
  static_cast<void>(net::all_filters(kAsked, true));
  static_cast<void>(net::filters_before(kAsked, false, 1, 1));
  static_cast<void>(net::waiting_in_queue(kAsked));
  static_cast<void>(net::keep_priority_queue(kAsked));
}

void can_rules() {
  net::KernelCanRules rules;
  const auto there = rules.read();
  if (!there) return;
  for (const auto& rule : *there) {
    demand(rule.rule.from > 0 && rule.rule.to > 0);
    static_cast<void>(rules.remove(rule));
  }
}

void conversation() {
  struct Unref {
    void operator()(sd_event* loop) const { sd_event_unref(loop); }
  };
  sd_event* raw = nullptr;
  demand(sd_event_new(&raw) >= 0);
  const std::unique_ptr<sd_event, Unref> loop(raw);
  auto opened = net::Conversation::open(loop.get(), NETLINK_GENERIC);
  demand(opened.has_value());
  int ended = 0;
  (*opened)->find_family("nl80211", [&ended](const Result<std::uint16_t>&) { ++ended; });
  (*opened)->ask(
      net::Conversation::generic_request(GENL_ID_CTRL, CTRL_CMD_GETFAMILY, NLM_F_DUMP),
      [](net::genl::Octets octets) {
        static_cast<void>(net::wire::read_interface(octets));
        static_cast<void>(net::genl::read_message(octets));
      },
      [&ended](int) { ++ended; });
  // An answer that never ends, ends: at the latest behind as many messages as one may have, and a
  // turn reads no more than its part.
  for (std::size_t turns = 0; ended < 2 && turns < 5000; ++turns) {
    if (!kernel.endless && kernel.next_answer == kernel.answers.size() && turns > 4) return;
    sd_event_run(loop.get(), 0);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  kernel = Kernel{};
  kernel.endless = (data[0] & 0x80U) != 0;
  fuzz::Pieces pieces({reinterpret_cast<const char*>(data) + 1, size - 1});
  while (!pieces.done()) {
    const auto piece = pieces.next();
    if (piece.empty()) continue;
    const auto fate = static_cast<unsigned char>(piece[0]);
    auto& to = (fate & Fate::notice) != 0 ? kernel.notices : kernel.answers;
    to.push_back({fate, {piece.begin() + 1, piece.end()}});
  }
  kernel.answers_now = true;
  switch (data[0] & 0x7fU) {
    case 'l':
      links();
      break;
    case 'q':
      queues();
      break;
    case 'c':
      static_cast<void>(net::read_controller(kAsked));
      break;
    case 'r':
      can_rules();
      break;
    case 'g':
      conversation();
      break;
    default:
      break;
  }
  kernel.answers_now = false;
  return 0;
}
