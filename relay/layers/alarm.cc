// SPDX-License-Identifier: BSD-2-Clause
#include "relay/layers/alarm.hpp"

#include <sys/epoll.h>
#include <sys/timerfd.h>

#include <algorithm>
#include <utility>

#include "relay/layers/sockets.hpp"

namespace mlcca::relay {

Result<std::unique_ptr<Alarm>> Alarm::beside(int socket) {
  Fd epoll(::epoll_create1(EPOLL_CLOEXEC));
  Fd timer(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK));
  if (!epoll || !timer) return system_error("a timer for a layer");
  for (const int fd : {socket, timer.get()}) {
    epoll_event event{.events = EPOLLIN, .data = {.fd = fd}};
    if (::epoll_ctl(epoll.get(), EPOLL_CTL_ADD, fd, &event) != 0) return system_error("epoll");
  }
  return std::unique_ptr<Alarm>(new Alarm(std::move(epoll), std::move(timer)));
}

/// Setting the timer also makes it unreadable again.
void Alarm::set(std::optional<std::uint64_t> at) {
  constexpr std::uint64_t second = 1'000'000'000;
  itimerspec when{};
  if (at) {
    const std::uint64_t time = std::max<std::uint64_t>(*at, 1);  // 0 would disarm the timer
    when.it_value = {.tv_sec = static_cast<time_t>(time / second),
                     .tv_nsec = static_cast<long>(time % second)};
  }
  ::timerfd_settime(timer_.get(), TFD_TIMER_ABSTIME, &when, nullptr);
}

}  // namespace mlcca::relay
