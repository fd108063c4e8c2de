// SPDX-License-Identifier: BSD-2-Clause
#include "relay/famouso/subscriber_program.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <random>
#include <utility>
#include <variant>
#include <vector>

#include "mlcca/attribute.hpp"

namespace mlcca::relay {
namespace {

constexpr std::size_t kMostOfTurn = 64;
constexpr std::uint64_t kAskAgain = 10'000'000'000;  // ns; for changes that no event reports
constexpr std::chrono::milliseconds kPause(20);

/// The sender as text: "0x12" for a node, "192.0.2.7", or "0xbeef:0x0002"; "station" if it has no
/// address.
std::string source_text(const control::Endpoint& endpoint, const Layer::Arrival& arrival) {
  if (endpoint.wpan) return arrival.station.empty() ? "station" : std::string(arrival.station);
  const std::uint32_t source = arrival.source;
  constexpr unsigned node_shift = 14;
  constexpr std::uint32_t nodes = 0x7f;
  if (endpoint.can) return fmt::format("{:#04x}", source >> node_shift & nodes);
  const in_addr address{.s_addr = htonl(source)};
  std::array<char, INET_ADDRSTRLEN> text{};
  ::inet_ntop(AF_INET, &address, text.data(), text.size());
  return text.data();
}

}  // namespace

SubscriberProgram::SubscriberProgram(std::string socket, std::uint32_t user, Outside outside)
    : user_(user),
      outside_(std::move(outside)),
      subscriptions_({.send = [this](const auto& network, Octets event) { send(network, event); },
                      .ask =
                          [this](control::SubscribeRequest request) {
                            return ask({0, std::move(request), true});
                          },
                      .report =
                          [this](control::RefusalRequest request) {
                            if (link_.is_connected()) link_.send({0, std::move(request)});
                          },
                      .log = outside_.log,
                      .random = [] { return std::random_device{}(); }}),
      announcer_(
          {.send = [this](const auto& network, Octets event) { send(network, event); },
           .ask = [this](control::PresenceRequest request) { return ask({0, std::move(request)}); },
           .longest = [this](const auto& network) { return longest_on(network); }}),
      link_(std::move(socket), {.connected =
                                    [this] {
                                      subscriptions_.ask_all();
                                      announcer_.ask_now();
                                      asked_ = 0;
                                      ask_what_there_is();
                                    },
                                .lost =
                                    [this] {
                                      subscriptions_.daemon_gone();
                                      announcer_.daemon_gone();
                                    },
                                .reply = [this](const auto& reply) { on_reply(reply); },
                                .event = [this](const auto& event) { on_event(event); },
                                .timer = [this] { ask_what_there_is(); },
                                .log = outside_.log}) {
  link_.start();
}

// --- the daemon ----------------------------------------------------------------------------------

std::uint64_t SubscriberProgram::ask(control::Request request) {
  if (!link_.is_connected() || link_.unsent() > DaemonLink::kMostUnsent) return 0;
  return link_.send(std::move(request));
}

void SubscriberProgram::ask_what_there_is() {
  if (asked_ != 0) {
    due_ = true;
    return;
  }
  due_ = false;
  asked_at_ = outside_.now();
  asked_ = link_.send({0, control::SubscriptionsRequest{}, true});
}

void SubscriberProgram::on_reply(const control::Reply& reply) {
  if (announcer_.answered(reply.id, reply, outside_.now())) return;
  if (reply.id != asked_) {
    subscriptions_.answered(reply.id, reply, outside_.now());
    return;
  }
  asked_ = 0;
  link_.is_well();
  if (const auto* said = std::get_if<control::Subscriptions>(&reply.body)) {
    control::Subscriptions own = *said;
    std::erase_if(own.networks, [this](const auto& one) { return one.user != user_; });
    open(own);
    subscriptions_.set(own, outside_.now());
  } else {
    due_ = true;
  }
  if (due_) link_.set_timer(kPause);
}

void SubscriberProgram::on_event(const control::Event& event) {
  const Affects affected = affected_by(event);
  if (affected == Affects::nothing) return;
  if (affected == Affects::all) {
    subscriptions_.ask_all();
    announcer_.ask_now();
  } else {
    subscriptions_.decided(event.subject);
  }
  due_ = true;
  if (asked_ == 0) link_.set_timer(kPause);
}

// --- networks ------------------------------------------------------------------------------------

void SubscriberProgram::close(const std::string& network) {
  const auto known = networks_.find(network);
  if (known == networks_.end()) return;
  outside_.watch(known->second.layer->fd(), false);
  networks_.erase(known);
}

void SubscriberProgram::open(const control::Subscriptions& said) {
  std::vector<std::string> gone;
  for (const auto& [name, network] : networks_)
    if (std::ranges::none_of(said.networks, [&](const auto& one) {
          return one.network == name && one.endpoint == network.endpoint && one.problem.empty();
        }))
      gone.push_back(name);
  for (const std::string& name : gone) close(name);
  for (const control::SubscriptionNetwork& one : said.networks) {
    if (!one.problem.empty() || networks_.contains(one.network)) continue;
    auto layer = open_layer(one.endpoint);
    const auto done =
        layer ? (*layer)->follow(0, one.endpoint, kSubscriptionSubject, kLongestSubscription)
              : Result<void>();
    if (!layer || !done) {
      outside_.log(fmt::format("subscriptions on {}: {}", one.network,
                               layer ? done.error().text : layer.error().text));
      due_ = true;
      continue;
    }
    outside_.watch((*layer)->fd(), true);
    outside_.log(fmt::format("subscriptions on {} ({})", one.network, one.endpoint.interface));
    networks_.emplace(one.network, Network{one.endpoint, std::move(*layer)});
  }
}

void SubscriberProgram::receive(int fd) {
  if (fd == link_.fd()) {
    link_.turn();
    return;
  }
  for (auto& [name, network] : networks_) {
    if (network.layer->fd() != fd) continue;
    const bool there = network.layer->receive(kMostOfTurn, [&](const Layer::Arrival& arrival) {
      if (announcer_.receive(name, arrival.event, outside_.now())) return;
      subscriptions_.receive(name, source_text(network.endpoint, arrival), arrival.event,
                             outside_.now());
    });
    if (link_.is_connected()) link_.flush();
    if (!there) close(std::string(name));
    return;
  }
}

std::size_t SubscriberProgram::longest_on(const std::string& network) const {
  const auto known = networks_.find(network);
  return known == networks_.end() ? kLongestSubscription : longest_at(known->second.endpoint);
}

void SubscriberProgram::send(const std::string& network, Octets event) {
  const auto known = networks_.find(network);
  if (known == networks_.end()) return;
  const Sent sent = known->second.layer->send(known->second.endpoint, kSubscriptionSubject, event);
  std::string trouble;
  if (sent != Sent::sent)
    trouble = network +
              ": subscriptions do not leave: the queue is full, or the gate drops them "
              "(control-user of the Port)";
  if (trouble != std::exchange(trouble_, trouble) && !trouble.empty()) outside_.log(trouble);
}

void SubscriberProgram::turn() {
  const std::uint64_t now = outside_.now();
  if (link_.is_connected() && asked_ == 0 && now - asked_at_ >= kAskAgain) ask_what_there_is();
  subscriptions_.turn(now);
  announcer_.turn(now);
  for (const auto& [name, network] : networks_)
    if (network.layer->holds_parts()) network.layer->expire();
  if (link_.is_connected()) link_.flush();
}

}  // namespace mlcca::relay
