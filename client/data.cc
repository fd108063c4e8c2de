// SPDX-License-Identifier: BSD-2-Clause
#include "client/data.hpp"

#include <sys/epoll.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <iterator>
#include <set>
#include <variant>

#include "base/clock.hpp"
#include "base/timer.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::client {
namespace {

using relay::Sent;

/// Events taken from each socket in one call of process(); if more are pending, the descriptor
/// stays readable.
constexpr std::size_t kMostEvents = 64;
/// Events from programs on the gateway that are read before `missing` may be reported.
constexpr std::size_t kMostBefore = 1024;
constexpr std::chrono::seconds kExpiry(1);
/// How long (ns) events are at most sent to a receiver that the daemon does not state.
constexpr std::uint64_t kMostKept = 3'600'000'000'000;

std::chrono::system_clock::time_point time_of(std::uint64_t unix_ns) {
  using Time = std::chrono::system_clock::time_point;
  return Time(std::chrono::duration_cast<Time::duration>(std::chrono::nanoseconds(unix_ns)));
}

std::string text_of_time(std::uint64_t ns) {
  constexpr std::uint64_t milli = 1'000'000;
  constexpr std::uint64_t second = 1'000 * milli;
  return ns % second == 0 ? std::to_string(ns / second) + " s" : std::to_string(ns / milli) + " ms";
}

bool is_local(const SharedEndpoint& endpoint) { return !endpoint->local.empty(); }

bool is_of_programs(const SharedEndpoint& endpoint) { return endpoint->user.has_value(); }

/// Publishers with a granted delivery on the gateway itself.
std::vector<std::string> granted_here(const std::vector<control::Channel>& deliveries) {
  std::vector<std::string> out;
  for (const control::Channel& delivery : deliveries)
    if (delivery.granted && delivery.from == delivery.to) out.push_back(delivery.publisher);
  return out;
}

/// Whether two shared or weak pointers have the same owner.
bool is_same(const auto& a, const auto& b) { return !a.owner_before(b) && !b.owner_before(a); }

}  // namespace

// --- sockets -------------------------------------------------------------------------------------

Client::Data::Data(const Fd& epoll)
    : epoll_(epoll),
      timer_(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK)),
      supervision_(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK)),
      senders_(epoll) {
  for (const Fd* timer : {&timer_, &supervision_})
    if (*timer) static_cast<void>(watch(timer->get()));
}

bool Client::Data::watch(int fd) const {
  epoll_event event{.events = EPOLLIN, .data = {.fd = fd}};
  return ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, fd, &event) == 0;
}

std::string Client::Data::address(const PartOf& part) {
  if (!part->local || part->local->address().empty()) {
    auto receiver = LocalReceiver::open();
    const bool is_watched = receiver && watch(receiver->fd());
    why_no_receiver_ = receiver ? "epoll" : receiver.error().text;
    if (!is_watched) return {};
    part->local = std::make_shared<LocalReceiver>(std::move(*receiver));
    receivers_[part->local->fd()] = part->local;
    if (part->subject != 0) share_receiver(part);
  }
  return part->local->address();
}

/// Uses one receiver for all subscribers of a channel, because the daemon keeps one address for
/// each channel of a connection.
void Client::Data::share_receiver(const PartOf& part) {
  if (!part->local || part->local->subject() == part->subject) return;
  const auto known = std::ranges::find_if(
      receivers_, [&](const auto& one) { return one.second->subject() == part->subject; });
  if (known == receivers_.end()) {
    part->local->set_subject(part->subject);
    return;
  }
  // Since the last subscriber of this receiver left, nothing checked whether its publishers are
  // still granted. So they must not keep a valid key.
  if (known->second.use_count() == 1) known->second->change_key();
  const int former = part->local->fd();
  part->local = known->second;
  const auto own = receivers_.find(former);
  if (own != receivers_.end() && own->second.use_count() == 1) receivers_.erase(own);
  if (!part->local->address().empty()) return;
  receivers_.erase(known);
  part->local.reset();
}

/// Changes the key when a publisher has lost its grant, because that publisher still knows the
/// former key.
void Client::Data::hold_publishers(const PartOf& part, std::vector<std::string> granted) {
  const bool lost = std::ranges::any_of(part->local_publishers, [&](const std::string& one) {
    return std::ranges::find(granted, one) == granted.end();
  });
  part->local_publishers = std::move(granted);
  if (!lost || !part->local) return;
  const int fd = part->local->fd();
  part->local->change_key();
  if (part->local->address().empty()) receivers_.erase(fd);
}

Result<relay::Layer*> Client::Data::layer_of(const control::Endpoint& endpoint) {
  const auto known = layers_.find(endpoint.ifindex);
  if (known != layers_.end() && !known->second.serves(endpoint))
    return fail(endpoint.network + " is not what it was: the daemon is asked");
  if (known != layers_.end()) return known->second.layer.get();
  auto layer = relay::open_layer(endpoint);
  if (!layer) return std::unexpected(layer.error());
  if (!watch((*layer)->fd()))
    return fail(std::string("epoll: ") + std::strerror(errno));  // NOLINT(concurrency-mt-unsafe)
  return layers_
      .emplace(endpoint.ifindex,
               relay::OpenedLayer{relay::form_of_layer(endpoint), std::move(*layer)})
      .first->second.layer.get();
}

/// Channels that received from the former layer lose their endpoints there; the daemon states new
/// ones when they are announced again.
Result<relay::Layer*> Client::Data::renewed_layer_of(const control::Endpoint& endpoint) {
  const auto known = layers_.find(endpoint.ifindex);
  if (known != layers_.end() && !known->second.serves(endpoint))
    for (const Following& one : close(endpoint.ifindex))
      if (const auto part = one.part.lock())
        std::erase_if(part->endpoints, [&](const auto& other) { return *other == *one.endpoint; });
  return layer_of(endpoint);
}

// --- who sends and receives where ----------------------------------------------------------------

/// An interface from which a channel receives by several endpoints counts once.
std::uint64_t Client::Data::lost_on_networks(const std::weak_ptr<Channel::Part>& part,
                                             std::optional<std::uint32_t> only) const {
  std::map<std::uint32_t, std::uint64_t> before;  // by interface
  for (const auto& [follower, one] : following_) {
    const std::uint32_t ifindex = one.endpoint->ifindex;
    if (!is_same(one.part, part) || ifindex != only.value_or(ifindex)) continue;
    const auto at = before.try_emplace(ifindex, one.lost_before).first;
    at->second = std::min(at->second, one.lost_before);
  }
  std::uint64_t all = 0;
  for (const auto& [ifindex, lost] : before)
    if (const auto layer = layers_.find(ifindex); layer != layers_.end())
      all += layer->second.layer->losses().all() - lost;
  return all;
}

void Client::Data::leave(const std::weak_ptr<Channel::Part>& part) {
  if (const auto left = part.lock()) left->lost_events += lost_on_networks(part);
  std::erase_if(following_, [&](const auto& one) {
    const auto& [follower, following] = one;
    if (!is_same(following.part, part)) return false;
    if (const auto layer = layers_.find(following.endpoint->ifindex); layer != layers_.end())
      layer->second.layer->leave(follower, *following.endpoint, following.subject);
    return true;
  });
}

void Client::Data::leave_expired() {
  for (auto it = following_.begin(); it != following_.end();) {
    const auto part = it->second.part;
    ++it;
    if (!part.expired()) continue;
    leave(part);
    it = following_.begin();
  }
}

/// Closes the layer of an interface and returns the subscriptions that used it.
std::vector<Client::Data::Following> Client::Data::close(std::uint32_t ifindex) {
  std::vector<Following> former;
  const auto known = layers_.find(ifindex);
  if (known == layers_.end()) return former;
  other_losses_ += known->second.layer->losses().all();
  std::set<PartOf> concerned;
  for (const auto& [follower, one] : following_)
    if (auto part = one.part.lock(); part && one.endpoint->ifindex == ifindex)
      concerned.insert(std::move(part));
  for (const PartOf& part : concerned) part->lost_events += lost_on_networks(part, ifindex);
  layers_.erase(known);
  std::erase_if(following_, [&](auto& one) {
    if (one.second.endpoint->ifindex != ifindex) return false;
    former.push_back(std::move(one.second));
    return true;
  });
  return former;
}

/// Replaces a layer whose socket is unusable. If the interface exists, the same channels receive
/// from it again; otherwise they do when the daemon states it again.
void Client::Data::renew(std::uint32_t ifindex) {
  for (Following& one : close(ifindex)) {
    const auto part = one.part.lock();
    if (!part) continue;
    const auto layer = layer_of(*one.endpoint);
    if (layer && (*layer)->follow(++last_, *one.endpoint, one.subject, kMostLocalBytes)) {
      one.lost_before = (*layer)->losses().all();
      following_.emplace(last_, std::move(one));
    } else {
      part->endpoints.clear();
    }
  }
}

Result<void> Client::Data::use(const PartOf& part, const control::Reply& reply) {
  part->open_until = Channel::Part::kOpen;
  const auto* channels = std::get_if<control::Channels>(&reply.body);
  if (channels == nullptr) {
    hold_publishers(part, {});
    return use_endpoints(part, {});
  }
  if (channels->grace_ns != 0) grace_ns_ = channels->grace_ns;
  if (!channels->channels.empty()) {
    part->subject = channels->channels.front().subject;
    share_receiver(part);
  }
  hold_publishers(part, granted_here(channels->channels));
  auto done = use_endpoints(part, channels->endpoints);
  if (done && !part->local && std::ranges::any_of(part->endpoints, is_of_programs))
    return fail("programs on this gateway: " + why_no_receiver_);
  if (done && !channels->local_problem.empty())
    return fail("programs on this gateway: " + channels->local_problem);
  return done;
}

/// Opens the layer for publishers as well, so that the first event does not wait for a socket.
Result<void> Client::Data::use_endpoint(const PartOf& part, const SharedEndpoint& endpoint) {
  const auto layer = renewed_layer_of(*endpoint);
  if (!layer) return std::unexpected(layer.error());
  if (part->request.role == control::Role::publisher) return {};
  auto followed = (*layer)->follow(++last_, *endpoint, part->subject, kMostLocalBytes);
  if (followed)
    following_.emplace(last_, Following{part, endpoint, part->subject, (*layer)->losses().all()});
  return followed;
}

Result<void> Client::Data::use_endpoints(const PartOf& part,
                                         std::vector<control::Endpoint> stated) {
  leave_expired();
  const bool publishes = part->request.role == control::Role::publisher;
  const auto is_same_as = [](const control::Endpoint& one, const SharedEndpoint& other) {
    return one == *other;
  };
  if (!publishes && std::ranges::equal(stated, part->endpoints, is_same_as)) return {};
  std::vector<SharedEndpoint> endpoints;
  endpoints.reserve(stated.size());
  for (control::Endpoint& one : stated) endpoints.push_back(endpoints_.share(std::move(one)));
  if (publishes) keep_former(part, endpoints);
  leave(part);
  std::erase_if(publishers_,
                [&](const auto& other) { return other.expired() || is_same(other, part); });
  use_local(part, endpoints);
  Result<void> done;
  std::erase_if(endpoints, [&](const SharedEndpoint& endpoint) {
    if (is_of_programs(endpoint) || is_local(endpoint)) return false;
    const auto used = use_endpoint(part, endpoint);
    if (!used) done = fail(endpoint->network + ": " + used.error().text);
    return !used && !publishes;  // the next answer tries it again
  });
  part->endpoints = std::move(endpoints);
  if (publishes && std::ranges::any_of(part->endpoints, is_local)) publishers_.push_back(part);
  const auto kept = close_unused_senders();
  return done ? kept : done;
}

/// Takes the endpoints of programs on the gateway. The supervision of a user that is already known
/// goes on.
void Client::Data::use_local(const PartOf& part, const std::vector<SharedEndpoint>& endpoints) {
  std::vector<Local> before;
  std::erase_if(locals_, [&](Local& one) {
    if (!one.part.expired() && !is_same(one.part, part)) return false;
    if (!one.part.expired()) before.push_back(std::move(one));
    return true;
  });
  const std::uint64_t now = monotonic_ns();
  for (const SharedEndpoint& endpoint : endpoints) {
    if (!is_of_programs(endpoint)) continue;
    const auto known = std::ranges::find_if(
        before, [&](const Local& one) { return one.source.granted().user == endpoint->user; });
    locals_.push_back(known == before.end() ? Local{part, LocalSource(*endpoint, now)} : *known);
    locals_.back().source.grant(*endpoint);
    if (const auto due = locals_.back().source.due()) supervise_at(*due, now);
  }
}

/// Adds the former receivers of a publisher that the daemon does not state, if the publisher is
/// still granted on the gateway and something receives there. After a restart of the daemon, their
/// programs may not have announced them yet.
void Client::Data::keep_former(const PartOf& part, std::vector<SharedEndpoint>& endpoints) {
  std::set<LocalSenders::Receiver> stated;
  for (const SharedEndpoint& endpoint : endpoints)
    if (is_local(endpoint)) stated.insert(LocalSenders::receiver_of(*endpoint));
  std::vector<SharedEndpoint> kept = part->endpoints;
  if (part->local_publishers.empty()) kept.clear();
  std::erase_if(kept, [&](const SharedEndpoint& former) {
    return !is_local(former) || stated.contains(LocalSenders::receiver_of(*former)) ||
           (own_at(former->local) == nullptr && !senders_.reaches(*former, part->subject));
  });
  former_receivers_.keep(part, kept,
                         add_saturating(monotonic_ns(), std::min(grace_ns_, kMostKept)));
  endpoints.insert(endpoints.end(), kept.begin(), kept.end());
}

Result<void> Client::Data::close_unused_senders() {
  std::set<LocalSenders::Receiver> used;
  for (const auto& weak : publishers_)
    if (const auto part = weak.lock())
      for (const SharedEndpoint& endpoint : part->endpoints)
        if (is_local(endpoint)) used.insert(LocalSenders::receiver_of(*endpoint));
  senders_.keep_only(used);
  if (used.size() <= LocalSenders::kMost) return {};
  return fail("programs on this gateway: there are " + std::to_string(used.size()) +
              " receivers, and a program sends to at most " + std::to_string(LocalSenders::kMost));
}

// --- events --------------------------------------------------------------------------------------

Published Client::Data::publish(const PartOf& part, Octets event) {
  if (event.size() > kMostLocalBytes) return Published::too_long;
  std::size_t sent = 0;
  std::size_t lost = 0;
  bool too_long = false;
  std::vector<SharedEndpoint> gone;
  for (const SharedEndpoint& endpoint : part->endpoints) {
    const Passed passed = send_to(part, endpoint, event);
    too_long = too_long || passed == Passed::too_long;
    if (passed == Passed::sent) ++sent;
    if (passed == Passed::lost || passed == Passed::too_long) ++lost;
    if (passed == Passed::gone) gone.push_back(endpoint);
  }
  // Nobody is there who could have got the event. One that the daemon states is looked for again
  // later.
  for (const SharedEndpoint& endpoint : gone)
    if (former_receivers_.forget(part, endpoint)) std::erase(part->endpoints, endpoint);
  if (lost == 0) return sent == 0 ? Published::not_granted : Published::sent;
  if (sent != 0) return Published::partly;
  return too_long ? Published::too_long : Published::lost;
}

Client::Data::Passed Client::Data::send_to(const PartOf& part, const SharedEndpoint& endpoint,
                                           Octets event) {
  if (is_local(endpoint)) return send_local(part, endpoint, event);
  const auto layer = layer_of(*endpoint);
  if (!layer) return Passed::lost;
  const Sent how = (*layer)->send(*endpoint, part->subject, event);
  // The interface has gone, but it may exist again with the same index.
  if (how == Sent::failed) renew(endpoint->ifindex);
  if (how == Sent::sent) return Passed::sent;
  return how == Sent::too_long ? Passed::too_long : Passed::lost;
}

/// The receiver of this program at an address; null if it is one of another program.
LocalReceiver* Client::Data::own_at(const std::string& address) {
  const auto own = std::ranges::find_if(
      receivers_, [&](const auto& one) { return one.second->address() == address; });
  return own == receivers_.end() ? nullptr : own->second.get();
}

/// Counts an event that must not be sent to a receiver, so that the receiver knows of it. Nullopt:
/// it may be sent.
std::optional<Client::Data::Passed> Client::Data::withhold(const PartOf& part,
                                                           const SharedEndpoint& endpoint,
                                                           LocalReceiver* own) {
  const auto former_until =
      former_receivers_.empty() ? std::nullopt : former_receivers_.until(part, endpoint);
  if (part->open_until == Channel::Part::kOpen && !former_until) return std::nullopt;
  const std::uint64_t now = monotonic_ns();
  const bool is_due = former_until && now >= *former_until;
  if (now < part->open_until && !is_due) return std::nullopt;
  if (own != nullptr)
    own->lose_to_itself();
  else if (senders_.withhold(*endpoint, part->subject) == LocalSender::Sent::gone)
    return Passed::gone;
  return former_until ? Passed::not_granted : Passed::lost;
}

Client::Data::Passed Client::Data::send_local(const PartOf& part, const SharedEndpoint& endpoint,
                                              Octets event) {
  if (endpoint->frame_bytes != 0 && event.size() > endpoint->frame_bytes) return Passed::too_long;
  const std::uint64_t subject = part->subject;
  LocalReceiver* const own = own_at(endpoint->local);
  if (const auto withheld = withhold(part, endpoint, own)) return *withheld;
  if (own != nullptr) return own->send_to_itself(subject, event) ? Passed::sent : Passed::lost;
  const auto sent = senders_.send(*endpoint, subject, event);
  if (sent == LocalSender::Sent::gone) return Passed::gone;
  return sent == LocalSender::Sent::sent ? Passed::sent : Passed::lost;
}

std::size_t Client::Data::receive_local(LocalReceiver& receiver, std::size_t most) {
  buffer_.resize(LocalReceiver::kBuffer);
  return receiver.receive(most, buffer_,
                          [&](const LocalEvent& event) { take_local(receiver, event); });
}

/// The subject is compared as well, so that a sender that knows the key of one channel cannot send
/// to another channel with it.
void Client::Data::take_local(const LocalReceiver& receiver, const LocalEvent& event) {
  const std::uint64_t when = event.unix_ns == 0 ? unix_ns() : event.unix_ns;
  const std::uint64_t now = monotonic_ns();
  std::optional<std::uint64_t> lost;
  for (Local& one : locals_) {
    const auto part = one.part.lock();
    if (!part || part->local.get() != &receiver || part->subject != event.subject ||
        one.source.granted().user != event.from)
      continue;
    const bool is_closed = now >= part->open_until;
    const std::uint64_t missed = event.missed + (is_closed && !event.is_notice ? 1 : 0);
    one.source.miss(missed, now);
    lost = std::max(lost.value_or(0), missed);
    part->lost_events += missed;
    if (!event.is_notice && !is_closed) {
      if (one.source.takes(event.octets.size(), when, now)) {
        arrived_.push_back({one.part, {}, {event.octets.begin(), event.octets.end()}, when});
      } else {
        ++other_losses_;
        ++part->lost_events;
      }
    }
    if (const auto due = one.source.due()) supervise_at(*due, now);
  }
  other_losses_ += lost.value_or(0);
}

/// Sets the timer for `due` unless it expires earlier. It may expire too early, because events have
/// arrived since it was set; supervise() then sets it again.
void Client::Data::supervise_at(std::uint64_t due, std::uint64_t now) {
  if (supervised_at_ != 0 && supervised_at_ <= due) return;
  supervised_at_ = due;
  constexpr std::uint64_t in_a_milli = 1'000'000;
  const std::uint64_t left = due > now ? due - now : 0;
  start_timer(supervision_, std::chrono::milliseconds(left / in_a_milli + 1));
}

/// Events that wait in the socket count as having arrived in time, so they are read first.
void Client::Data::supervise() {
  std::uint64_t expired = 0;
  if (::read(supervision_.get(), &expired, sizeof expired) != sizeof expired) return;
  for (const auto& [fd, receiver] : receivers_) receive_local(*receiver, kMostBefore);
  supervised_at_ = 0;
  const std::uint64_t now = monotonic_ns();
  for (Local& one : locals_) {
    const auto part = one.part.lock();
    if (!part) continue;
    while (auto event = one.source.happened(now)) {
      event->subject = part->subject;
      happened_.push_back({part, std::move(*event)});
    }
    if (const auto due = one.source.due()) supervise_at(*due, now);
  }
  report_lapses(now);
}

// --- a daemon that is gone -----------------------------------------------------------------------

void Client::Data::lose_daemon(const PartOf& part, std::uint64_t since) {
  const std::uint64_t at = add_saturating(since, grace_ns_);
  if (part->endpoints.empty() || at >= part->open_until) return;
  part->open_until = at;
  if (std::ranges::none_of(lapses_, [&](const auto& one) { return is_same(one, part); }))
    lapses_.emplace_back(part);
  supervise_at(at, monotonic_ns());
}

void Client::Data::close_local(const PartOf& part) {
  part->open_until = 0;
  std::erase_if(lapses_, [&](const auto& one) { return is_same(one, part); });
}

/// The gates of the kernel close at the same time.
void Client::Data::report_lapses(std::uint64_t now) {
  std::erase_if(lapses_, [&](const std::weak_ptr<Channel::Part>& weak) {
    const auto part = weak.lock();
    if (!part || part->open_until == Channel::Part::kOpen) return true;
    if (now < part->open_until) {
      supervise_at(part->open_until, now);
      return false;
    }
    control::Event event;
    event.kind = "lapsed";
    event.subject = part->subject;
    event.message =
        "mlccad has not answered for its grace, " + text_of_time(grace_ns_) +
        ": the gates close, and events between programs on this gateway are not delivered";
    happened_.push_back({part, std::move(event)});
    return true;
  });
}

std::vector<Client::Data::Happened> Client::Data::take_happened() {
  return std::exchange(happened_, {});
}

void Client::Data::take(const relay::Layer::Arrival& arrival) {
  const auto known = following_.find(arrival.follower);
  if (known == following_.end()) return;
  const auto& [part, endpoint, subject, lost_before] = known->second;
  arrived_.push_back({part,
                      endpoint->network,
                      {arrival.event.begin(), arrival.event.end()},
                      arrival.unix_ns == 0 ? unix_ns() : arrival.unix_ns});
}

bool Client::Data::receive(int fd) {
  if (const auto local = receivers_.find(fd); local != receivers_.end()) {
    receive_local(*local->second, kMostEvents);
    return true;
  }
  if (timer_.get() == fd) {
    expire();
    return true;
  }
  if (supervision_.get() == fd) {
    supervise();
    return true;
  }
  const auto found =
      std::ranges::find_if(layers_, [fd](const auto& one) { return one.second.layer->fd() == fd; });
  if (found == layers_.end()) return senders_.on_room(fd);
  if (!found->second.layer->receive(kMostEvents, [this](const auto& arrival) { take(arrival); }))
    renew(found->first);
  else if (!is_timed_ && found->second.layer->holds_parts())
    time_expiry();
  return true;
}

bool Client::Data::holds_parts() const {
  return std::ranges::any_of(layers_,
                             [](const auto& one) { return one.second.layer->holds_parts(); });
}

void Client::Data::time_expiry() {
  start_timer(timer_, kExpiry);
  is_timed_ = true;
}

/// Called once a second as long as incomplete events exist.
void Client::Data::expire() {
  std::uint64_t expired = 0;
  if (::read(timer_.get(), &expired, sizeof expired) != sizeof expired) return;
  is_timed_ = false;
  for (const auto& [ifindex, one] : layers_)
    if (one.layer->holds_parts()) one.layer->expire();
  if (holds_parts()) time_expiry();
}

/// If a handler throws, the events behind it are kept for the next call.
void Client::Data::call_handlers() {
  std::vector<Arrived> all = std::exchange(arrived_, {});
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto part = all[i].part.lock();
    const auto handler = part ? part->on_event : nullptr;  // a copy: the handler may replace it
    if (!handler) continue;
    Event event;
    event.data = all[i].octets.data();
    event.size = all[i].octets.size();
    event.network = all[i].network.c_str();
    event.received = time_of(all[i].unix_ns);
    try {
      (*handler)(event);
    } catch (...) {
      arrived_.assign(std::move_iterator(all.begin() + static_cast<std::ptrdiff_t>(i) + 1),
                      std::move_iterator(all.end()));
      throw;
    }
  }
}

std::uint64_t Client::Data::lost(const PartOf& part) const {
  return part->lost_events + lost_on_networks(part);
}

std::uint64_t Client::Data::lost() const {
  std::uint64_t all = other_losses_;
  for (const auto& [ifindex, one] : layers_) all += one.layer->losses().all();
  return all;
}

}  // namespace mlcca::client
