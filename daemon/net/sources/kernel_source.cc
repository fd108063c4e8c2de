// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/sources/kernel_source.hpp"

#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <netlink/attr.h>
#include <netlink/msg.h>
#include <netlink/netlink.h>
#include <netlink/socket.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include "base/system_error.hpp"
#include "base/throttle.hpp"

namespace mlcca::net {
namespace {

constexpr std::uint64_t kInterval = kPollInterval * 1000;  // ns between polls
constexpr std::uint64_t kSoon = 100'000'000;               // ns
constexpr int kNotices = 256;                              // in one turn
constexpr std::uint64_t kAfterNotice = 50'000'000;  // ns between polls that are caused by notices

}  // namespace

void KernelSource::FreeSocket::operator()(nl_sock* socket) const noexcept {
  nl_socket_free(socket);
}

Result<void> KernelSource::start() {
  if (auto joined = join_notices(); !joined) return joined;
  return timer_.start(loop_, [this] { begin(); });
}

Result<void> KernelSource::join_notices() {
  notices_.reset(nl_socket_alloc());
  if (!notices_) return fail("nl_socket_alloc: out of memory");
  nl_socket_disable_seq_check(notices_.get());
  int e = nl_connect(notices_.get(), NETLINK_ROUTE);
  if (e >= 0) e = nl_socket_add_membership(notices_.get(), RTNLGRP_LINK);
  if (e >= 0) e = nl_socket_set_nonblocking(notices_.get());
  if (e < 0) return fail(std::string("rtnetlink link notifications: ") + nl_geterror(e));
  sd_event_source* raw = nullptr;
  const auto on_notice = [](sd_event_source*, int, std::uint32_t, void* self) noexcept {
    static_cast<KernelSource*>(self)->take_notices();
    return 0;
  };
  e = sd_event_add_io(loop_, &raw, nl_socket_get_fd(notices_.get()), EPOLLIN, on_notice, this);
  noticed_.reset(raw);
  if (e < 0) return system_error("rtnetlink link notifications", -e);
  return {};
}

void KernelSource::take_notices() {
  // The next poll reads what has changed, so the content of a notice is not used. An overflow
  // (ENOBUFS) counts as a notice.
  std::array<char, 1024> sink{};
  const int fd = nl_socket_get_fd(notices_.get());
  for (int i = 0; i < kNotices; ++i)
    if (::recv(fd, sink.data(), sink.size(), MSG_TRUNC) < 0 && errno != ENOBUFS && errno != EINTR)
      break;
  poll_at(begun_ + kAfterNotice);
}

void KernelSource::poll_at(std::uint64_t when) { arm(std::min(next_, when)); }

void KernelSource::arm(std::uint64_t when) {
  next_ = when;
  const std::uint64_t time = now();
  timer_.set(when > time ? (when - time) / 1000 : 0);
}

void KernelSource::begin() {
  const std::uint64_t time = now();
  if (polling_ && time < begun_ + kInterval) {
    // A notice came during a poll that has not seen the change.
    arm(std::min(begun_ + kInterval, time + kAfterNotice));
    return;
  }
  if (polling_) report_problem("the kernel did not answer within a second");
  polling_ = true;
  begun_ = time;
  arm(begun_ + kInterval);
  poll();
}

void KernelSource::ask_link(const std::string& interface, Conversation::OnMessage each,
                            std::function<void()> end) {
  Conversation* const kernel = talk(NETLINK_ROUTE);
  if (kernel == nullptr) return;
  auto request = Conversation::route_request(RTM_GETLINK, 0);
  if (request) {
    ifinfomsg any{};
    nlmsg_append(request.get(), &any, sizeof any, NLMSG_ALIGNTO);
    nla_put_string(request.get(), IFLA_IFNAME, interface.c_str());
  }
  kernel->ask(std::move(request), std::move(each), [this, interface, end = std::move(end)](int e) {
    if (e == ENODEV)
      report_problem("there is no interface " + interface);
    else if (e != 0)
      report_refusal("state of " + interface, e);
    else
      end();
  });
}

void KernelSource::ask_family(const char* family, const std::string& interface,
                              std::function<void(Conversation&, std::uint16_t, unsigned)> ask) {
  const auto index = std::make_shared<unsigned>(0);
  ask_link(
      interface, [index](genl::Octets octets) { *index = genl::index_of_link(octets).value_or(0); },
      [this, index, family, interface, ask = std::move(ask)] {
        if (*index == 0) {
          report_problem("the kernel gave no index of " + interface);
          return;
        }
        Conversation* const kernel = talk(NETLINK_GENERIC);
        if (kernel == nullptr) return;
        kernel->find_family(family, [this, index, ask](Result<std::uint16_t> number) {
          if (number)
            ask(*talk(NETLINK_GENERIC), *number, *index);
          else
            report_problem(std::move(number.error().text));
        });
      });
}

Conversation* KernelSource::talk(int protocol) {
  auto& conversation = protocol == NETLINK_ROUTE ? route_ : generic_;
  if (conversation) return conversation.get();
  auto opened = Conversation::open(loop_, protocol);
  if (!opened) {
    report_problem(std::move(opened.error().text));
    return nullptr;
  }
  conversation = std::move(*opened);
  return conversation.get();
}

void KernelSource::end() {
  polling_ = false;
  generic_.reset();
  route_.reset();
}

void KernelSource::report(core::mesh::Snapshot snapshot) {
  end();
  report_(std::move(snapshot));
}

void KernelSource::report_problem(std::string problem) {
  report({.links = {}, .next_hops = {}, .problem = std::move(problem)});
}

void KernelSource::report_refusal(const std::string& what, int error) {
  if (error != EINTR) {
    report_problem(error_words(what, error));
    return;
  }
  end();
  poll_again_soon();
}

void KernelSource::poll_again_soon() { poll_at(begun_ + kSoon); }

}  // namespace mlcca::net
