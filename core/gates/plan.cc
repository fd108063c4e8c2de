// SPDX-License-Identifier: BSD-2-Clause
#include "core/gates/plan.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "core/gates/difference.hpp"
#include "core/gates/together.hpp"
#include "core/model/carrier.hpp"
#include "core/model/medium.hpp"
#include "core/model/progress.hpp"
#include "core/profiles/profile.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::core {
namespace {

/// Collects rules. If two publishers have the same entry, it passes only if both may pass.
class Rules {
 public:
  void add(const GateRule& rule) {
    auto [it, fresh] = rules_.try_emplace(rule.entry, rule);
    if (fresh) return;
    it->second.pass = it->second.pass && rule.pass;
    it->second.policing = together(it->second.policing, rule.policing, rule.entry.max_length);
    it->second.watching = together(it->second.watching, rule.watching);
    shared_.insert(rule.entry);
  }
  [[nodiscard]] GateState take() const {
    GateState state;
    state.reserve(rules_.size());
    for (const auto& [entry, rule] : rules_) {
      state.push_back(rule);
      if (shared_.contains(entry)) state.back().watching = of_several(rule);
      Progress::step();
    }
    return state;
  }

 private:
  /// The supervision of a rule shared by several publishers. An event of one may be taken for a
  /// part of an event of another, so the time is longer by that. If nothing passes, nothing is
  /// missing.
  static Watching of_several(const GateRule& rule) {
    Watching out = rule.pass ? rule.watching : Watching{};
    if (out.silence != 0) out.silence = add_saturating(out.silence, out.together);
    return out;
  }

  std::map<GateEntry, GateRule> rules_;
  std::set<GateEntry> shared_;
};

class Planner {
 public:
  Planner(const System& system, const Members& members, std::size_t gateway)
      : system_(system), members_(members), here_{Place::Kind::gateway, gateway} {}

  /// Adds the rules of one publisher: where its events arrive at this gateway, and where they
  /// leave.
  void add(std::size_t publisher, const std::vector<const Verdict*>& verdicts) {
    resent_.clear();
    set_ = verdicts.empty() ? 0 : verdicts.front()->set;  // one set for all of a channel
    silence_ = shortest_silence(verdicts);
    std::map<std::pair<std::size_t, std::size_t>, bool> out;  // (in, out) ports
    std::map<std::size_t, bool> in;
    for (const Verdict* v : verdicts)
      for (const auto& crossing : crossings(*v)) {
        if (crossing.in != kLocal) in[crossing.in] |= v->granted;
        if (crossing.out != kLocal) out[{crossing.in, crossing.out}] |= v->granted;
        if (!crossing.as_sent) resent_.insert(crossing.in);
      }
    // A publisher on one of our networks whose events no subscriber needs here is known, but its
    // frames do not pass.
    const Publisher& p = members_.publisher(publisher);
    if (p.place.kind == Place::Kind::network)
      if (const std::size_t port = port_on(p.place.index); port != kLocal)
        in.try_emplace(port, false);

    for (const auto& [port, pass] : in) emit(p, port, Direction::ingress, kLocal, pass);
    for (const auto& [ports, pass] : out)
      emit(p, ports.second, Direction::egress, ports.first, pass);
  }

  [[nodiscard]] GateState take() const { return rules_.take(); }

  /// Adds the passages of one publisher whose ends at networks are gated.
  void add_passages(std::size_t publisher, const std::vector<const Verdict*>& verdicts,
                    std::vector<Passage>& to) {
    resent_.clear();
    for (const Verdict* v : verdicts)
      for (const auto& crossing : crossings(*v))
        if (!crossing.as_sent) resent_.insert(crossing.in);
    for (const Verdict* v : verdicts) {
      if (!v->granted) continue;
      set_ = v->set;
      for (const Crossing& crossing : crossings(*v))
        if (auto found = passage(publisher, crossing)) to.push_back(*std::move(found));
    }
  }

 private:
  static Value shortest_silence(const std::vector<const Verdict*>& verdicts) {
    Value shortest = kUnbounded;
    for (const Verdict* v : verdicts)
      if (const Value silence = silence_of(*v); silence != 0)
        shortest = std::min(shortest, silence);
    return shortest;
  }
  static constexpr std::size_t kLocal = ~std::size_t{0};
  struct Crossing {
    std::size_t in;
    std::size_t out;
    bool as_sent;  ///< they are the publisher's own frames: no bus or program was before
  };

  /// Nullopt if one end is at a network that no gate can judge.
  [[nodiscard]] std::optional<Passage> passage(std::size_t publisher, const Crossing& c) const {
    const Publisher& p = members_.publisher(publisher);
    Passage out{.publisher = publisher, .set = set_};
    if (c.in != kLocal) out.in = entry(p, c.in, Direction::ingress, kLocal);
    if (c.out != kLocal) out.out = entry(p, c.out, Direction::egress, c.in);
    if (out.in.has_value() != (c.in != kLocal) || out.out.has_value() != (c.out != kLocal))
      return std::nullopt;
    out.by_kernel = c.in != kLocal && c.out != kLocal && is_joined_by_kernel(c.in, c.out);
    return out;
  }

  [[nodiscard]] std::size_t port_on(std::size_t network) const {
    const auto& ports = system_.gateways[here_.index].ports;
    const auto it = std::ranges::find(ports, network, &Port::network);
    return it == ports.end() ? kLocal : static_cast<std::size_t>(it - ports.begin());
  }

  /// Where the verdict's route crosses this gateway. A refusal without a route applies at the
  /// publisher's own network and at the target.
  [[nodiscard]] std::vector<Crossing> crossings(const Verdict& v) const {
    std::vector<Crossing> found;
    bool as_sent = true;
    for (std::size_t i = 0; i < v.route.size(); ++i) {
      if (v.route[i] != here_) {
        as_sent = as_sent && !is_bus(v.route[i]) && !is_resent(v.route, i);
        continue;
      }
      const std::size_t in = i == 0 ? kLocal : port_on(v.route[i - 1].index);
      const std::size_t out = i + 1 == v.route.size() ? kLocal : port_on(v.route[i + 1].index);
      found.push_back({in, out, as_sent});
    }
    return found;
  }

  [[nodiscard]] bool is_joined_by_kernel(std::size_t in, std::size_t out) const {
    return are_joined_by_kernel(system_.gateways[here_.index], network_at(in), network_at(out));
  }
  /// Whether a program of the gateway at that index of the route sends the events in frames of its
  /// own.
  [[nodiscard]] bool is_resent(const std::vector<Place>& route, std::size_t at) const {
    return route[at].kind == Place::Kind::gateway && at > 0 && at + 1 < route.size() &&
           !are_joined_by_kernel(system_.gateways[route[at].index],
                                 system_.networks[route[at - 1].index],
                                 system_.networks[route[at + 1].index]);
  }

  [[nodiscard]] bool is_bus(Place hop) const {
    return hop.kind == Place::Kind::network && system_.networks[hop.index].kind == NetworkKind::can;
  }

  [[nodiscard]] const Network& network_at(std::size_t port) const {
    return system_.networks[system_.gateways[here_.index].ports[port].network];
  }

  /// The entry for a publisher's frames at a port. Nullopt if no gate can distinguish the frames,
  /// or no sender is allowed.
  [[nodiscard]] std::optional<GateEntry> entry(const Publisher& p, std::size_t port,
                                               Direction direction, std::size_t source) const {
    const Network& network = network_at(port);
    const Binding* binding = network.binding_of(p.channel);
    const bool bound = network.carries_subjects() || binding != nullptr;
    if (!names_channels(network.profile) || !bound) return std::nullopt;
    if (binding != nullptr && binding->waits_for_tag()) return std::nullopt;
    GateEntry e;
    e.port = port;
    e.direction = direction;
    e.subject = system_.channels[p.channel].subject;
    if (network.carries_subjects()) {
      const std::size_t in = direction == Direction::ingress ? port : source;
      const bool as_sent = in != kLocal && !resent_.contains(in) &&
                           (direction == Direction::ingress || is_joined_by_kernel(in, port));
      if (as_sent) e.station = p.station;
      size_datagram(p, in, as_sent, network, e);
    } else if (!identify(p, network, *binding, e)) {
      return std::nullopt;
    }
    if (direction == Direction::egress) {
      if (const auto& sender = sender_between(source, port))
        e.uid = *sender;
      else if (source != kLocal)
        come_from(p, source, network, e);
      else if (p.uid)
        e.uid = *p.uid;
      else
        return std::nullopt;  // a local publisher without a user: no program may send
    }
    return e;
  }

  /// Distinguishes frames that leave with the same identifier by the identity with which they
  /// arrived.
  void come_from(const Publisher& p, std::size_t source, const Network& out, GateEntry& e) const {
    e.source_port = source;
    if (out.carries_subjects() || network_at(source).carries_subjects()) return;
    // The frames arrived at port `source`: it is the port of that ingress entry.
    // NOLINTNEXTLINE(readability-suspicious-call-argument)
    if (const auto in = entry(p, source, Direction::ingress, kLocal))
      e.entered_as = {.id = in->id, .mask = in->mask};
  }

  void emit(const Publisher& p, std::size_t port, Direction direction, std::size_t source,
            bool pass) {
    const auto e = entry(p, port, direction, source);
    if (!e) return;
    // A frame that arrived at another port has been policed there.
    const bool first = direction == Direction::ingress || source == kLocal;
    GateRule rule{*e, pass, {}, {}};
    if (first) {
      const AttributeSet& offered = attributes_in(p, set_);
      const Network& network = network_at(port);
      const auto frames =
          frames_per_event(network, network.binding_of(p.channel), offered[Attribute::max_payload]);
      rule.policing = policing_of(
          offered, frames, network.carries_subjects() ? event_bytes(network) : e->max_length);
      rule.policing.counts_only = system_.gateways[here_.index].ports[port].excess == Excess::pass;
      // Of a transported message only the announcement is supervised.
      if (system_.channels[p.channel].arrival == Arrival::periodic)
        rule.watching = watching(offered, e->transport ? 1 : frames);
    }
    rules_.add(rule);
  }

  /// The supervision of events. Frames of one event come together; after half a period a frame
  /// belongs to the next event.
  [[nodiscard]] Watching watching(const AttributeSet& offered, std::uint64_t frames) const {
    const Value period = offered[Attribute::period];
    if (period == 0) return {};
    return {period, silence_ == kUnbounded ? 0 : silence_, frames > 1 ? period / 2 : 0};
  }

  /// The user ID of the program that carries events from one port to the other; nullopt if the
  /// kernel does, or nobody may.
  [[nodiscard]] std::optional<std::uint32_t> sender_between(std::size_t in, std::size_t out) const {
    if (in == kLocal) return std::nullopt;
    const auto& ports = system_.gateways[here_.index].ports;
    return is_joined_by_kernel(in, out) ? std::nullopt
                                        : sender_at(system_.gateways[here_.index], ports[out]);
  }

  /// Whether the datagrams of another publisher at the same place cannot be distinguished from
  /// those of `p`: on its own network only the address does so, behind a bus nothing does.
  static bool is_indistinguishable(const Publisher& p, const Publisher& other, bool as_sent) {
    return other.place == p.place && (!as_sent || other.station == p.station);
  }

  /// Sets the length to that of the longest event of all publishers that share the entry.
  void size_datagram(const Publisher& p, std::size_t in, bool as_sent, const Network& network,
                     GateEntry& e) const {
    const auto size_of = [&](const Publisher& publisher) {
      const AttributeSet& offered = attributes_in(publisher, set_);
      return offered.has(Attribute::max_payload) ? offered[Attribute::max_payload]
                                                 : event_bytes(network);
    };
    Value bytes = size_of(p);
    if (in != kLocal)
      for (const std::size_t number : members_.publishers_of(p.channel))
        if (const Publisher& other = members_.publisher(number);
            is_indistinguishable(p, other, as_sent))
          bytes = std::max(bytes, size_of(other));
    e.fragmented = is_fragmented(network, nullptr, bytes);
    e.max_length = static_cast<std::uint16_t>(std::min<Value>(bytes, datagram_bytes(network)));
  }

  [[nodiscard]] std::optional<FrameIdentity> identity_on(const Publisher& p, const Network& network,
                                                         const Binding& b) const {
    return identity_of(p, network, b,
                       is_fragmented(network, &b, attributes_in(p, set_)[Attribute::max_payload]));
  }

  /// Payload bytes of a frame, or of the message if it is transported.
  [[nodiscard]] std::uint16_t frame_length(const Publisher& p, const Network& network,
                                           const Binding& b) const {
    const AttributeSet& offered = attributes_in(p, set_);
    const bool sized = offered.has(Attribute::max_payload);
    const Value bytes = offered[Attribute::max_payload];
    if (transport_of(network, &b, bytes) != nullptr)
      return static_cast<std::uint16_t>(std::min(bytes, event_bytes(network, b)));
    return static_cast<std::uint16_t>(
        sized ? frame_bytes(network, b, offered[Attribute::max_payload]) : frame_bytes(b));
  }

  /// Fills in formats and identity, and the length of the longest frame of all publishers that
  /// cannot be distinguished. Returns false if the publisher has no identity on the network.
  [[nodiscard]] bool identify(const Publisher& p, const Network& network, const Binding& b,
                              GateEntry& e) const {
    e.classic = b.format == FrameFormat::classic || b.format == FrameFormat::any;
    e.fd = b.format == FrameFormat::fd || b.format == FrameFormat::any;
    e.xl = b.format == FrameFormat::xl;
    const auto identity = identity_on(p, network, b);
    if (!identity) return false;
    e.max_length = frame_length(p, network, b);
    for (const std::size_t number : members_.publishers_of(p.channel)) {
      const Publisher& other = members_.publisher(number);
      if (other.place == p.place && identity_on(other, network, b) == identity)
        e.max_length = std::max(e.max_length, frame_length(other, network, b));
    }
    e.transport = transport_of(network, &b, e.max_length) != nullptr;
    e.id = identity->id;
    e.mask = identity->mask | (b.remote_frames ? 0 : kRemoteFlag);
    return true;
  }

  const System& system_;
  const Members& members_;
  Place here_;
  std::size_t set_ = 0;           ///< attribute set of the channel
  Value silence_ = 0;             ///< of the publisher being added; kUnbounded: none
  std::set<std::size_t> resent_;  ///< ports at which its frames come from the forwarding program
  Rules rules_;
};

std::vector<const Verdict*> of_publisher(const std::vector<Verdict>& verdicts,
                                         std::size_t publisher) {
  std::vector<const Verdict*> found;
  for (const Verdict& v : verdicts)
    if (v.publisher == publisher) found.push_back(&v);
  return found;
}

void add_publisher(Planner& planner, std::size_t publisher, const std::vector<Verdict>& verdicts) {
  planner.add(publisher, of_publisher(verdicts, publisher));
}

void add_channel(Planner& planner, const Members& members, std::size_t channel,
                 const std::vector<Verdict>& verdicts, AdmissionId without = 0) {
  for (const std::size_t publisher : members.publishers_of(channel)) {
    if (without == 0 || members.admission_of_publisher(publisher) != without)
      add_publisher(planner, publisher, verdicts);
    Progress::step();
  }
}

}  // namespace

bool goes_elsewhere(const Verdict& verdict, const GateState& rules) {
  return verdict.granted && !rules.empty() && std::ranges::none_of(rules, &GateRule::pass);
}

GateState gate_state(const System& system, const Members& members, std::size_t channel,
                     const std::vector<Verdict>& verdicts, std::size_t gateway,
                     AdmissionId without) {
  Planner planner(system, members, gateway);
  add_channel(planner, members, channel, verdicts, without);
  return planner.take();
}

std::vector<Passage> passages(const System& system, const Members& members, std::size_t channel,
                              const std::vector<Verdict>& verdicts, std::size_t gateway) {
  std::vector<Passage> found;
  Planner planner(system, members, gateway);
  for (const std::size_t publisher : members.publishers_of(channel)) {
    planner.add_passages(publisher, of_publisher(verdicts, publisher), found);
    Progress::step();
  }
  std::ranges::sort(found);
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

std::vector<Transit> transits(const System& system, const Members& members, std::size_t channel,
                              const std::vector<Verdict>& verdicts, std::size_t gateway) {
  std::vector<Transit> found;
  const auto is_can = [&](const Port& port) {
    return system.networks[port.network].kind == NetworkKind::can;
  };
  const auto is_bus = [&](const GateEntry& entry) {
    return is_can(system.gateways[gateway].ports[entry.port]);
  };
  if (std::ranges::count_if(system.gateways[gateway].ports, is_can) < 2) return found;
  for (const Passage& p : passages(system, members, channel, verdicts, gateway))
    if (p.by_kernel && is_bus(*p.in)) found.push_back({*p.in, *p.out});
  std::ranges::sort(found);
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

GateState gate_state(const System& system, const Members& members,
                     const std::vector<Decision>& decisions, std::size_t gateway) {
  Planner planner(system, members, gateway);
  for (std::size_t c = 0; c < decisions.size(); ++c)
    add_channel(planner, members, c, decisions[c].verdicts);
  return planner.take();
}

GateState gate_state(const System& system, const Members& members, const Verdict& verdict,
                     std::size_t gateway) {
  Planner planner(system, members, gateway);
  planner.add(verdict.publisher, {&verdict});
  return planner.take();
}

std::optional<std::string> exceeds_capacity(const System& system, const Members& members,
                                            std::size_t channel,
                                            const std::vector<Verdict>& verdicts,
                                            std::size_t gateway) {
  if (members.publishers_of(channel).size() <= kMostEntries) return std::nullopt;
  std::map<std::pair<std::size_t, Direction>, std::size_t> entries;
  for (const GateRule& rule : gate_state(system, members, channel, verdicts, gateway)) {
    const Gateway& here = system.gateways[gateway];
    const Network& network = system.networks[here.ports[rule.entry.port].network];
    const std::size_t most = network.carries_subjects() ? kMostEntries : kMostBusEntries;
    if (++entries[{rule.entry.port, rule.entry.direction}] <= most) continue;
    return "more than " + std::to_string(most) + " publishers of it " +
           (rule.entry.direction == Direction::ingress ? "enter" : "leave") + " gateway " +
           here.name + " by network " + network.name +
           ": a gate distinguishes no more of one subject";
  }
  return std::nullopt;
}

std::vector<SharedRule> shared_rules(const System& system, const Members& members,
                                     std::size_t channel, const std::vector<Verdict>& verdicts,
                                     std::size_t gateway) {
  if (members.publishers_of(channel).size() < 2) return {};
  std::map<GateEntry, std::vector<std::size_t>> users;
  for (const std::size_t publisher : members.publishers_of(channel)) {
    Planner planner(system, members, gateway);
    add_publisher(planner, publisher, verdicts);
    for (const GateRule& rule : planner.take()) users[rule.entry].push_back(publisher);
  }
  std::erase_if(users, [](const auto& of_entry) { return of_entry.second.size() < 2; });
  std::vector<SharedRule> shared;
  if (users.empty()) return shared;
  for (const GateRule& rule : gate_state(system, members, channel, verdicts, gateway))
    if (const auto known = users.find(rule.entry); known != users.end())
      shared.push_back({rule, std::move(known->second)});
  return shared;
}

std::vector<GateEntry> entries_of(const std::vector<SharedRule>& shared) {
  std::vector<GateEntry> entries;
  entries.reserve(shared.size());
  for (const SharedRule& one : shared) entries.push_back(one.rule.entry);
  return entries;
}

GateChanges gate_changes_between(const GateState& now, const GateState& next) {
  return difference_of<GateChanges>(
      now, next, [](const GateRule& a, const GateRule& b) { return a.entry < b.entry; },
      [](const GateRule& rule) { return rule.entry; },
      [](const GateRule& a, const GateRule& b) {
        return a.policing == b.policing && a.watching == b.watching;
      });
}

}  // namespace mlcca::core
