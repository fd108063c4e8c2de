// SPDX-License-Identifier: BSD-2-Clause
#include "relay/famouso/subscriptions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <tuple>
#include <variant>

#include "control/attributes.hpp"

namespace mlcca::relay {
namespace {

using Kind = Subscription::Kind;

constexpr std::uint64_t kInASecond = 1'000'000'000;
/// Delay (ns) until an own subscription is sent again without the peer that was refused.
constexpr std::uint64_t kWithout = kInASecond;
constexpr std::uint64_t kOwnLease = 3 * Subscriptions::kRenewal;
constexpr const char* kTooFar =
    "it has come over as many gateways as may be: no further one passes it on";

/// The lease in ns, limited to the allowed range.
std::uint64_t lease_of(const Subscription& wanted) {
  return std::clamp(wanted.lease_s, Subscriptions::kShortestLease, Subscriptions::kLongestLease) *
         kInASecond;
}

/// Why a reply refuses a subscription; nullopt if it grants it.
std::optional<std::string> refusal_in(const control::Reply& reply) {
  if (const auto* error = std::get_if<control::Error>(&reply.body)) return error->message;
  const auto* channels = std::get_if<control::Channels>(&reply.body);
  if (channels == nullptr) return std::nullopt;
  for (const control::Channel& one : channels->channels)
    if (!one.granted) return fmt::format("{} to {}: {}", one.from, one.to, one.reason);
  if (channels->channels.empty()) return "nobody publishes it";
  return std::nullopt;
}

}  // namespace

// --- what the daemon says ------------------------------------------------------------------------

void Subscriptions::set_networks(const control::Subscriptions& said) {
  std::map<std::string, control::SubscriptionNetwork> networks;
  for (const control::SubscriptionNetwork& network : said.networks) {
    const auto before = networks_.find(network.network);
    if (!network.problem.empty() &&
        (before == networks_.end() || before->second.problem != network.problem))
      outside_.log(fmt::format("no subscriptions on {}: {}", network.network, network.problem));
    if (network.gateways_only) continue;
    networks.emplace(network.network, network);
  }
  networks_ = std::move(networks);
  std::erase_if(peers_, [&](const auto& one) { return !networks_.contains(one.first.network); });
}

Subscriptions::AllWanted Subscriptions::wanted_of(const control::Subscriptions& said) const {
  AllWanted wanted;
  for (const control::OnwardSubscription& one : said.onward) {
    const auto network = networks_.find(one.network);
    if (network == networks_.end() || !network->second.problem.empty()) continue;
    const auto required = control::set_of(one.required);
    if (one.problem.empty() && required)
      wanted.emplace(OwnKey{one.subject, one.network}, Wanted{*required, one.begins_here});
    else
      outside_.log(fmt::format("{} is not subscribed on {}: {}", one.channel, one.network,
                               required ? one.problem : required.error().text));
  }
  return wanted;
}

void Subscriptions::end_all_but(const AllWanted& wanted) {
  for (auto it = own_.begin(); it != own_.end();) {
    if (wanted.contains(it->first)) {
      ++it;
      continue;
    }
    Subscription over = it->second.message;
    over.kind = Kind::end;
    over.lease_s = 0;
    over.hops = 0;
    if (it->second.was_sent) send(it->first.network, over);
    it = own_.erase(it);
  }
}

void Subscriptions::set(const control::Subscriptions& said, std::uint64_t now) {
  set_networks(said);
  const AllWanted wanted = wanted_of(said);
  end_all_but(wanted);
  for (const auto& [key, now_wanted] : wanted) {
    const auto [at, fresh] = own_.try_emplace(key);
    Own& own = at->second;
    own.begins_here = now_wanted.begins_here;
    if (!fresh && own.message.required == now_wanted.required) continue;
    if (fresh)
      own.message.number = outside_.random();
    else
      own.renumber();
    own.message.kind = Kind::subscribe;
    own.message.subject = key.subject;
    own.message.required = now_wanted.required;
    own.message.lease_s = static_cast<std::uint16_t>(kOwnLease / kInASecond);
    own.due_at = now;
  }
  turn(now);
  answer_all();
}

/// How many gateways may still pass on an own subscription: the most that a peer behind it has
/// left. A subscription that did not arrive over a network starts with kHops.
std::uint8_t Subscriptions::hops_left(const OwnKey& key, const Own& own) const {
  if (own.begins_here) return kHops;
  std::optional<std::uint8_t> most;
  for (const auto& [peer, state] : peers_)
    if (peer.subject == key.subject && peer.network != key.network &&
        state.verdict == Verdict::granted)
      most =
          std::max(most.value_or(0), state.wanted.kind == Kind::plain ? kHops : state.wanted.hops);
  return most.value_or(kHops);
}

std::size_t Subscriptions::longest_on(const std::string& network) const {
  const auto known = networks_.find(network);
  return known == networks_.end() ? kLongestSubscription : longest_at(known->second.endpoint);
}

void Subscriptions::send(const std::string& network, const Subscription& message) {
  outside_.send(network, encode(message, longest_on(network)));
}

void Subscriptions::send_own(const OwnKey& key, Own& own, std::uint64_t now) {
  if (is_ending(key.subject)) {
    own.due_at = now + kWithout;
    return;
  }
  own.due_at = now + kRenewal;
  if (own.refused && now - own.refused_at >= kOwnLease) {  // the gateway that refused is gone
    own.refused.reset();
    answer_all();
  }
  const std::uint8_t left = hops_left(key, own);
  if (left == 0) return;  // too many gateways are on the way
  own.message.hops = static_cast<std::uint8_t>(left - 1);
  const auto message = encode(own.message);
  if (const std::size_t longest = longest_on(key.network); message.size() > longest) {
    own.answers["this gateway"] = {
        .refused = fmt::format("what is required takes {} octets, and a frame has {}",
                               message.size(), longest),
        .at = now};
    judge(key, own, now);
    return;
  }
  outside_.send(key.network, message);
  // FAMOUSO's own gateways get the plain message once, because they keep a subscription without
  // limit.
  if (!std::exchange(own.was_sent, true)) {
    Subscription plain;
    plain.subject = key.subject;
    send(key.network, plain);
  }
}

// --- messages ------------------------------------------------------------------------------------

void Subscriptions::receive(const std::string& network, const std::string& source, Octets event,
                            std::uint64_t now) {
  const auto accepting = networks_.find(network);
  const auto message = parse_subscription(event);
  if (!message || accepting == networks_.end()) return;
  PeerKey key{network, message->subject, source};
  switch (message->kind) {
    case Kind::plain:
      // A peer that states attributes sends the plain message as well, for gateways of FAMOUSO.
      if (accepting->second.accepts_all && !peers_.contains(key))
        subscribe(std::move(key), *message, now);
      return;
    case Kind::subscribe:
      subscribe(std::move(key), *message, now);
      return;
    case Kind::end:
      end(key);
      return;
    case Kind::granted:
    case Kind::refused:
      on_answer(network, source, *message, now);
      return;
  }
}

void Subscriptions::subscribe(PeerKey key, const Subscription& message, std::uint64_t now) {
  auto known = peers_.find(key);
  if (known == peers_.end() && peers_on(key.network) >= networks_[key.network].most) {
    if (message.kind == Kind::plain) return;
    Subscription full{.kind = Kind::refused, .subject = message.subject, .number = message.number};
    full.reason = fmt::format("{} has as many subscriptions as it allows", key.network);
    send(key.network, full);
    return;
  }
  if (known == peers_.end()) known = peers_.emplace(key, Peer{.wanted = message}).first;
  Peer& peer = known->second;
  const bool is_same = peer.wanted.required == message.required;
  const bool holds = is_same && peer.verdict == Verdict::refused && now < peer.not_before;
  if (!is_same) {
    peer.not_before = 0;
    peer.proven = false;
  }
  peer.wanted = message;
  peer.to_answer = true;
  if (holds) {
    answer(known->first, peer);
    return;
  }
  if (message.kind == Kind::plain)
    peer.ends_at.reset();
  else
    peer.ends_at = now + lease_of(message);
  if (message.has_user_attributes) {
    peer.verdict = Verdict::refused;
    peer.reason = "user-defined attributes are not known to gateways on the way";
    peer.ends_at = peer.not_before = now + kRefusalHolds;
    answer(known->first, peer);
    return;
  }
  peer.to_ask = true;
  turn(now);
}

void Subscriptions::end(const PeerKey& key) {
  const auto known = peers_.find(key);
  if (known == peers_.end()) return;
  if (known->second.admitted || known->second.verdict == Verdict::unknown) to_end_.insert(key);
  peers_.erase(known);
}

// --- answers of others further on ----------------------------------------------------------------

/// Takes an answer to an own subscription.
void Subscriptions::on_answer(const std::string& network, const std::string& source,
                              const Subscription& message, std::uint64_t now) {
  const auto known = own_.find({message.subject, network});
  if (known == own_.end() || known->second.message.number != message.number) return;
  Own& own = known->second;
  std::erase_if(own.answers, [&](const auto& one) { return now - one.second.at >= kOwnLease; });
  if (own.answers.size() >= kMostAnswers && !own.answers.contains(source)) return;
  own.answers[source] = {
      .refused = message.kind == Kind::refused ? std::optional(message.reason) : std::nullopt,
      .at = now};
  judge(known->first, own, now);
}

/// Decides an own subscription by its answers. One gateway that grants it is enough, because the
/// events come through that one.
void Subscriptions::judge(const OwnKey& key, Own& own, std::uint64_t now) {
  const auto granting =
      std::ranges::find_if(own.answers, [](const auto& one) { return !one.second.refused; });
  if (granting != own.answers.end()) {
    for (const auto& [name, peer] : behind(key)) peer->proven = true;
    if (!own.refused) return;
    own.refused.reset();
    outside_.report(
        {.subject = key.subject, .network = key.network, .source = granting->first, .reason = {}});
    answer_all();
    return;
  }
  const auto& [source, answer] = *own.answers.begin();
  std::string why = fmt::format("{} on {}: {}", source, key.network, *answer.refused);
  if (refuse_one(key, own, why, now)) return;
  own.refused_at = now;
  own.is_of_message = true;
  if (own.refused == why) return;
  own.refused = std::move(why);
  outside_.report({.subject = key.subject,
                   .network = key.network,
                   .source = source,
                   .reason = *answer.refused});
  answer_all();
}

std::vector<std::pair<const Subscriptions::PeerKey*, Subscriptions::Peer*>> Subscriptions::behind(
    const OwnKey& key) {
  std::vector<std::pair<const PeerKey*, Peer*>> out;
  for (auto& [name, peer] : peers_)
    if (name.subject == key.subject && name.network != key.network &&
        peer.verdict == Verdict::granted)
      out.emplace_back(&name, &peer);
  return out;
}

/// Only a peer that was never granted together with the others can be the cause: preferably one
/// that was refused when it was alone, otherwise the latest one. A node of FAMOUSO is never
/// refused, because it requires no more than the channel does and does not ask again.
bool Subscriptions::refuse_one(const OwnKey& key, Own& own, const std::string& why,
                               std::uint64_t now) {
  const auto all = behind(key);
  if (all.size() + (own.begins_here ? 1 : 0) < 2) return false;
  const auto order = [](const auto& one) {
    const Peer& peer = *one.second;
    const bool is_known = peer.answered && !peer.answered->empty();
    return std::tuple(!peer.proven && peer.wanted.kind != Kind::plain, is_known, peer.joined);
  };
  const auto last = std::ranges::max_element(all, {}, order);
  if (!std::get<0>(order(*last))) return false;
  own.renumber();
  own.due_at = now + kWithout;
  put_back(*last->first, *last->second, why, now);
  turn(now);
  return true;
}

/// Refuses a peer. It may ask again after kRefusalHolds.
void Subscriptions::put_back(const PeerKey& key, Peer& peer, const std::string& why,
                             std::uint64_t now) {
  outside_.log(fmt::format("{} on {} subscribes {:#018x}: refused, {}", key.source, key.network,
                           key.subject, why));
  peer.verdict = Verdict::refused;
  peer.reason = why;
  peer.admitted = peer.to_ask = false;
  peer.ends_at = peer.not_before = now + kRefusalHolds;
  to_end_.insert(key);
  answer(key, peer);
}

/// A peer has come while the joint requirement is refused. The peers that caused the refusal are
/// refused, so that the newcomer is judged without them.
void Subscriptions::make_room_for(const PeerKey& newcomer, std::uint64_t now) {
  for (auto own = own_.lower_bound({newcomer.subject, {}});
       own != own_.end() && own->first.subject == newcomer.subject; ++own) {
    if (own->first.network == newcomer.network || !own->second.refused ||
        !own->second.is_of_message)
      continue;
    bool any = false;
    for (const auto& [key, peer] : behind(own->first)) {
      if (*key == newcomer || peer->proven || peer->wanted.kind == Kind::plain) continue;
      put_back(*key, *peer, *own->second.refused, now);
      any = true;
    }
    if (!any) continue;
    own->second.refused.reset();
    own->second.renumber();
    own->second.due_at = now + kWithout;
  }
}

bool Subscriptions::is_ending(std::uint64_t subject) const {
  return std::ranges::any_of(to_end_, [&](const PeerKey& key) { return key.subject == subject; }) ||
         std::ranges::any_of(asked_, [&](const auto& one) {
           return one.second.end && one.second.peer.subject == subject;
         });
}

std::optional<std::string> Subscriptions::refused_further_on(const PeerKey& key,
                                                             const Peer& peer) const {
  for (auto own = own_.lower_bound({key.subject, {}});
       own != own_.end() && own->first.subject == key.subject; ++own) {
    if (own->first.network == key.network) continue;
    const Own& passed_on = own->second;
    // Until the present requirement is answered, a peer that got a refusal keeps it.
    if (passed_on.refused && (passed_on.is_of_message || peer.answered == passed_on.refused))
      return passed_on.refused;
    if (hops_left(own->first, passed_on) == 0) return kTooFar;
  }
  return std::nullopt;
}

void Subscriptions::answer_all() {
  for (auto& [key, peer] : peers_)
    if (peer.verdict == Verdict::granted && !peer.to_answer) answer(key, peer);
}

/// Sends an answer to the peer if it differs from the last one, or if the peer expects one.
void Subscriptions::answer(const PeerKey& key, Peer& peer) {
  std::string why;
  if (peer.verdict == Verdict::refused) why = peer.reason;
  if (peer.verdict == Verdict::granted) why = refused_further_on(key, peer).value_or("");
  if (peer.verdict == Verdict::unknown) return;
  if (!std::exchange(peer.to_answer, false) && peer.answered == why) return;
  peer.answered = why;
  if (peer.wanted.kind == Kind::plain) return;  // nodes of FAMOUSO expect no answer
  Subscription out{.kind = why.empty() ? Kind::granted : Kind::refused,
                   .subject = key.subject,
                   .number = peer.wanted.number};
  out.reason = std::move(why);
  send(key.network, out);
}

// --- the daemon's decisions ----------------------------------------------------------------------

bool Subscriptions::ask(const PeerKey& key, const Subscription& wanted, bool end) {
  const bool plain = wanted.kind == Kind::plain;
  const std::uint64_t number = outside_.ask({.subject = key.subject,
                                             .network = key.network,
                                             .source = key.source,
                                             .required = control::attributes_of(wanted.required),
                                             .states_attributes = !plain,
                                             .lease_ns = plain ? 0 : lease_of(wanted),
                                             .end = end});
  if (number == 0) return false;
  asked_[number] = {.peer = key, .required = wanted.required, .end = end};
  return true;
}

void Subscriptions::answered(std::uint64_t request, const control::Reply& reply,
                             std::uint64_t now) {
  const auto asked = asked_.extract(request);
  if (asked.empty()) return;
  const auto known = peers_.find(asked.mapped().peer);
  if (asked.mapped().end || known == peers_.end() || known->second.to_ask) return turn(now);
  Peer& peer = known->second;
  // The peer has changed its requirement since, and that is asked as well.
  if (asked.mapped().required != peer.wanted.required) return;
  const auto refusal = refusal_in(reply);
  const Verdict before = std::exchange(peer.verdict, refusal ? Verdict::refused : Verdict::granted);
  peer.reason = refusal.value_or("");
  if (before != peer.verdict)
    outside_.log(fmt::format("{} on {} subscribes {:#018x}: {}", known->first.source,
                             known->first.network, known->first.subject,
                             refusal ? "refused, " + *refusal : "granted"));
  peer.admitted = peer.admitted || !refusal;
  if (!refusal && before != Verdict::granted) {
    peer.joined = ++joined_;
    make_room_for(known->first, now);
  }
  peer.not_before = refusal ? now + kRefusalHolds : 0;
  // Nothing was admitted, so the peer is forgotten soon and may ask again.
  const bool is_over = refusal && !peer.admitted;
  if (is_over && peer.wanted.kind != Kind::plain) peer.ends_at = now + kRefusalHolds;
  answer(known->first, peer);
  if (is_over && peer.wanted.kind == Kind::plain) peers_.erase(known);
  turn(now);
}

void Subscriptions::decided(std::uint64_t subject) {
  for (auto& [key, peer] : peers_)
    if (key.subject == subject && peer.admitted) peer.to_ask = true;
}

void Subscriptions::ask_all() {
  for (auto& [key, peer] : peers_)
    if (peer.admitted || peer.verdict == Verdict::unknown) peer.to_ask = true;
}

// --- time ----------------------------------------------------------------------------------------

std::size_t Subscriptions::peers_on(const std::string& network) const {
  return static_cast<std::size_t>(
      std::ranges::count_if(peers_, [&](const auto& one) { return one.first.network == network; }));
}

void Subscriptions::turn(std::uint64_t now) {
  std::vector<PeerKey> over;
  for (const auto& [key, peer] : peers_)
    if (peer.ends_at && *peer.ends_at <= now) over.push_back(key);
  // The lease at the daemon is as long, but it may end a little later.
  for (const PeerKey& key : over) end(key);
  for (auto it = to_end_.begin(); it != to_end_.end() && asked_.size() < kMostAsked;) {
    if (!ask(*it, {.kind = Kind::end}, true)) break;
    it = to_end_.erase(it);
  }
  for (auto& [key, peer] : peers_) {
    if (asked_.size() >= kMostAsked) break;
    if (peer.to_ask && now >= peer.not_before && ask(key, peer.wanted, false)) peer.to_ask = false;
  }
  for (auto& [key, own] : own_)
    if (own.due_at <= now) send_own(key, own, now);
}

}  // namespace mlcca::relay
