// SPDX-License-Identifier: BSD-2-Clause
#include "client/local_senders.hpp"

#include <sys/epoll.h>

#include <algorithm>
#include <cerrno>
#include <optional>
#include <utility>

namespace mlcca::client {

/// A receiver keeps its name when its key changes, so its sender is found by the name and goes on
/// counting.
bool LocalSenders::send(const std::string& address, std::uint64_t subject, Octets event) {
  const auto at = control::local_address_in(address);
  if (!at) return false;
  auto to = by_name_.find(at->name);
  if (to == by_name_.end()) {
    auto sender = LocalSender::open(*at);
    if (!sender) return false;
    if (by_name_.size() >= kMost) by_name_.erase(by_name_.begin());
    to = by_name_.emplace(at->name, std::move(*sender)).first;
  }
  to->second.use_key(at->key);
  const auto sent = to->second.send(subject, event);
  if (sent == LocalSender::Sent::full) wait_for_room(to->second);
  if (sent == LocalSender::Sent::gone) by_name_.erase(to);
  return sent == LocalSender::Sent::sent;
}

void LocalSenders::keep_only(const std::set<std::string>& addresses) {
  std::erase_if(by_name_, [&](const auto& one) {
    const auto next = addresses.lower_bound(one.first);  // an address begins with the name
    return next == addresses.end() || !next->starts_with(one.first);
  });
}

void LocalSenders::wait_for_room(const LocalSender& sender) const {
  epoll_event event{.events = EPOLLOUT | EPOLLONESHOT, .data = {.fd = sender.fd()}};
  if (::epoll_ctl(epoll_.get(), EPOLL_CTL_MOD, sender.fd(), &event) != 0 && errno == ENOENT)
    ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, sender.fd(), &event);
}

bool LocalSenders::on_room(int fd) {
  const auto found =
      std::ranges::find_if(by_name_, [fd](const auto& one) { return one.second.fd() == fd; });
  if (found == by_name_.end()) return false;
  const auto sent = found->second.send_notice();
  if (sent == LocalSender::Sent::full) wait_for_room(found->second);
  if (sent == LocalSender::Sent::gone) by_name_.erase(found);
  return true;
}

}  // namespace mlcca::client
