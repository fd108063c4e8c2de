// SPDX-License-Identifier: BSD-2-Clause
#include "client/local_senders.hpp"

#include <sys/epoll.h>

#include <algorithm>
#include <cerrno>
#include <tuple>
#include <utility>

#include "base/clock.hpp"

namespace mlcca::client {

LocalSenders::Receiver LocalSenders::receiver_of(const control::Endpoint& to) {
  return {to.local.substr(0, control::LocalAddress::kNameDigits), to.local_user};
}

/// The sender to an endpoint; the end if there can be none.
LocalSenders::Senders::iterator LocalSenders::of(const control::Endpoint& to) {
  const auto at = control::local_address_in(to.local);
  if (!at) return senders_.end();
  auto one = senders_.find({at->name, to.local_user});
  if (one == senders_.end()) one = add({at->name, to.local_user}, at->key);
  if (one == senders_.end()) return one;
  one->second.used = ++turn_;
  one->second.sender.use_key(at->key);
  return one;
}

LocalSender::Sent LocalSenders::send(const control::Endpoint& to, std::uint64_t subject,
                                     Octets event) {
  if (was_gone(to)) return LocalSender::Sent::gone;
  const auto one = of(to);
  if (one == senders_.end()) return LocalSender::Sent::full;
  LocalSender& sender = one->second.sender;
  const bool is_open = sender.fd() >= 0 || open(one);
  const auto sent = is_open ? sender.send(subject, event) : sender.lose(subject);
  one->second.owes = sent != LocalSender::Sent::sent;
  if (sent == LocalSender::Sent::full && is_open) wait_for_room(sender);
  if (sent != LocalSender::Sent::gone) return sent;
  open_ -= is_open ? 1 : 0;
  senders_.erase(one);
  return note_gone(receiver_of(to));
}

/// Any user can state an address where nothing receives, and it must not cost a socket for each
/// event.
LocalSender::Sent LocalSenders::note_gone(const Receiver& receiver) {
  gone_[receiver] = monotonic_ns() + kPause;
  return LocalSender::Sent::gone;
}

bool LocalSenders::was_gone(const control::Endpoint& to) {
  if (gone_.empty()) return false;
  const auto known = gone_.find(receiver_of(to));
  if (known == gone_.end()) return false;
  if (monotonic_ns() < known->second) return true;
  gone_.erase(known);
  return false;
}

LocalSender::Sent LocalSenders::withhold(const control::Endpoint& to, std::uint64_t subject) {
  if (was_gone(to)) return LocalSender::Sent::gone;
  const auto one = of(to);
  if (one == senders_.end()) return LocalSender::Sent::full;
  static_cast<void>(one->second.sender.lose(subject));
  one->second.owes = true;
  if (one->second.sender.fd() >= 0 || open(one)) return report(one);
  if (!one->second.sender.is_gone()) return LocalSender::Sent::full;
  senders_.erase(one);
  return note_gone(receiver_of(to));
}

bool LocalSenders::reaches(const control::Endpoint& to, std::uint64_t subject) {
  const auto one = of(to);
  if (one == senders_.end()) return false;
  one->second.sender.use_subject(subject);
  if (one->second.sender.fd() >= 0 || open(one)) return report(one) != LocalSender::Sent::gone;
  return !one->second.sender.is_gone();
}

/// Returns the end if there are too many, or if no random number can be had.
LocalSenders::Senders::iterator LocalSenders::add(const Receiver& receiver, std::uint64_t key) {
  if (senders_.size() >= kMost) return senders_.end();
  auto sender = LocalSender::to({.name = receiver.first, .key = key});
  if (!sender) return senders_.end();
  return senders_.emplace(receiver, One{.sender = std::move(*sender)}).first;
}

bool LocalSenders::open(Senders::iterator one) {
  make_room();
  if (!one->second.sender.open()) return false;
  ++open_;
  return true;
}

/// Closes the socket that was used longest ago; rather one that owes no report, for which nothing
/// is waited.
void LocalSenders::make_room() {
  if (open_ < kMostOpen) return;
  const auto order = [](const auto& one) {
    const auto& [sender, owes, used] = one.second;
    return std::tuple(sender.fd() < 0, owes, used);
  };
  const auto oldest = std::ranges::min_element(senders_, {}, order);
  oldest->second.sender.close();
  --open_;
}

void LocalSenders::keep_only(const std::set<Receiver>& receivers) {
  gone_.clear();
  std::erase_if(senders_, [&](const auto& one) {
    if (receivers.contains(one.first)) return false;
    open_ -= one.second.sender.fd() >= 0 ? 1 : 0;
    return true;
  });
}

void LocalSenders::wait_for_room(const LocalSender& sender) const {
  epoll_event event{.events = EPOLLOUT | EPOLLONESHOT, .data = {.fd = sender.fd()}};
  if (::epoll_ctl(epoll_.get(), EPOLL_CTL_MOD, sender.fd(), &event) != 0 && errno == ENOENT)
    ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, sender.fd(), &event);
}

/// Reports what was lost to a receiver, by an open socket. If the result is `full`, it is reported
/// when there is room.
LocalSender::Sent LocalSenders::report(Senders::iterator one) {
  const auto sent = one->second.sender.send_notice();
  one->second.owes = sent == LocalSender::Sent::full;
  if (one->second.owes) wait_for_room(one->second.sender);
  if (sent != LocalSender::Sent::gone) return sent;
  --open_;
  const Receiver receiver = one->first;
  senders_.erase(one);
  return note_gone(receiver);
}

/// A socket that need not wait any more makes room for the reports of those that were closed.
bool LocalSenders::on_room(int fd) {
  const auto found = std::ranges::find_if(
      senders_, [fd](const auto& one) { return one.second.sender.fd() == fd; });
  if (found == senders_.end()) return false;
  if (report(found) == LocalSender::Sent::full) return true;
  for (;;) {
    const auto next = std::ranges::find_if(
        senders_, [](const auto& one) { return one.second.owes && one.second.sender.fd() < 0; });
    if (next == senders_.end()) return true;
    if (!open(next)) {
      if (!next->second.sender.is_gone()) return true;  // no descriptors are left
      senders_.erase(next);
    } else if (report(next) == LocalSender::Sent::full) {
      return true;
    }
  }
}

}  // namespace mlcca::client
