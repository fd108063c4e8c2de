// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's protocols: what a local client sends, frames to brokers, and messages about
// subscriptions and of gateways. The first octet says which. A frame is its time since the one
// before it in 16 ms, its identifier (4 octets), its length, and its octets. A message is its time
// since the one before it in s, an octet with network, source and the daemon's answer, its length,
// and its octets.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "relay/famouso/announcer.hpp"
#include "relay/famouso/local_protocol.hpp"
#include "relay/famouso/node_numbers.hpp"
#include "relay/famouso/subscriptions.hpp"
#include "relay/famouso/tag_broker.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using namespace mlcca::relay;
using mlcca::fuzz::demand;

constexpr std::uint64_t kStep = 16'000'000;
using Octets = std::span<const std::uint8_t>;

/// In pieces whose lengths are the first octet of each.
void local_protocol(Octets rest) {
  LocalSession session;
  std::vector<LocalSession::Event> events;
  while (!rest.empty()) {
    const std::size_t piece = std::min<std::size_t>(rest[0], rest.size() - 1);
    session.take(rest.subspan(1, piece), events);
    rest = rest.subspan(1 + piece);
    demand(session.kept() <= 13 + LocalSession::kMostOctets, "more than one message is kept");
    demand(session.role() != LocalSession::Role::ended || !session.why().empty(), "no reason");
    for (const auto& event : events) session.send(event);
    demand(session.waiting().size() <= LocalSession::kMostWaiting, "too much waits");
    events.clear();
  }
}

template <class Take>
void frames(Octets rest, Take take) {
  std::uint64_t now = 0;
  while (rest.size() >= 6) {
    now += rest[0] * kStep;
    Frame frame;
    for (std::size_t i = 1; i < 5; ++i) frame.id = frame.id << 8U | rest[i];
    frame.id &= 0x1fffffffU;
    frame.length = static_cast<std::uint8_t>(std::min<std::size_t>({rest[5], 8, rest.size() - 6}));
    std::copy_n(rest.begin() + 6, frame.length, frame.data.begin());
    rest = rest.subspan(6U + frame.length);
    take(frame, now);
  }
}

void node_broker(Octets rest) {
  NodeBroker broker({1});
  frames(rest, [&](const Frame& frame, std::uint64_t now) {
    static_cast<void>(broker.expire(now));
    const auto answer = broker.take(frame, now);
    demand(!answer || (tag_of(*answer) == kNodeAnswer && answer->length == 8), "no answer of it");
    demand(broker.dealt().size() <= 127, "more numbers than there are");
    demand(broker.number_of({1}) == kHighestNode, "its own number has changed");
  });
}

void tag_broker(Octets rest) {
  TagBroker broker;
  frames(rest, [&](const Frame& frame, std::uint64_t) {
    const std::size_t before = broker.dealt().size();
    const auto first = broker.take(frame);
    demand(broker.take(frame) == first, "the same subject, another tag");
    demand(broker.dealt().size() <= before + 1, "more than one tag for a request");
  });
}

/// Any messages of few peers on two networks, and a daemon that answers now, later or never.
void subscriptions(Octets rest) {
  constexpr std::size_t most = 4;
  std::uint64_t now = 0;
  std::uint64_t asked = 0;
  std::vector<std::uint64_t> open;
  Subscriptions all({.send =
                         [](const std::string&, Octets event) {
                           demand(event.size() <= 256, "a message that is too long");
                           demand(parse_subscription(event).has_value(), "a message that is none");
                         },
                     .ask =
                         [&](const mlcca::control::SubscribeRequest& request) {
                           demand(request.subject != 0, "no subject");
                           open.push_back(++asked);
                           return asked;
                         },
                     .report = [](const mlcca::control::RefusalRequest&) {},
                     .log = [](const std::string&) {},
                     .random = [] { return 7U; }});
  mlcca::control::Subscriptions said;
  for (const char* name : {"bus", "lan"}) {
    said.networks.emplace_back();
    said.networks.back().network = name;
    said.networks.back().accepts_all = true;
    said.networks.back().most = most;
    said.onward.emplace_back();
    said.onward.back().network = name;
    said.onward.back().subject = 1;
  }
  all.set(said, now);
  while (rest.size() >= 3) {
    now += rest[0] * std::uint64_t{1'000'000'000};
    const std::uint8_t how = rest[1];
    const std::size_t length = std::min<std::size_t>(rest[2], rest.size() - 3);
    all.receive((how & 1U) != 0 ? "bus" : "lan", std::to_string(how >> 1U & 7U),
                rest.subspan(3, length), now);
    rest = rest.subspan(3 + length);
    if ((how & 16U) != 0) all.turn(now);
    if ((how & 32U) != 0) all.decided(1);
    demand(open.size() <= Subscriptions::kMostAsked, "too much is asked");
    if ((how & 64U) != 0 && !open.empty()) {
      mlcca::control::Channels answer;
      answer.channels.emplace_back();
      answer.channels.back().granted = (how & 128U) != 0;
      all.answered(open.back(), {0, answer}, now);
      open.pop_back();
    }
    demand(all.peers() <= 2 * most, "more peers than are allowed");
  }
}

/// Any messages of gateways on a network; each is its length and its octets.
void announcements(Octets rest) {
  std::uint64_t asked = 0;
  Announcer all({.send =
                     [](const std::string&, Octets event) {
                       demand(parse_announcement(event).has_value(), "a message that is none");
                     },
                 .ask =
                     [&](const mlcca::control::PresenceRequest& request) {
                       demand(request.gateway.empty() || request.gateway == "b",
                              "a gateway that is not known");
                       demand(request.not_received.size() <= 16, "too many names");
                       return ++asked;
                     }});
  std::uint64_t now = 1;
  all.turn(now);
  mlcca::control::Presence own;
  own.gateway = "a";
  own.interval_ns = kStep;
  own.others = {"b"};
  own.networks = {"lan"};
  demand(all.answered(1, {1, own}, now), "its own request is not known");
  while (!rest.empty()) {
    const std::size_t length = std::min<std::size_t>(rest[0], rest.size() - 1);
    const Octets event = rest.subspan(1, length);
    now += kStep;
    all.receive("lan", event, now);
    all.turn(now);
    if (const auto message = parse_announcement(event))
      demand(parse_announcement(encode(*message)) == message, "not the same message");
    rest = rest.subspan(1 + length);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  constexpr void (*kParts[])(Octets) = {local_protocol, node_broker, tag_broker, subscriptions,
                                        announcements};
  kParts[data[0] % std::size(kParts)](Octets(data + 1, size - 1));
  return 0;
}
