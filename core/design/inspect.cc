// SPDX-License-Identifier: BSD-2-Clause
#include "core/design/inspect.hpp"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <utility>

#include "core/admission/allocation.hpp"
#include "core/admission/route_check.hpp"
#include "core/admission/senders.hpp"
#include "core/admission/world.hpp"
#include "core/can/analysis.hpp"
#include "core/can/of_system.hpp"
#include "core/design/contest.hpp"
#include "core/design/explain.hpp"
#include "core/design/hints.hpp"
#include "core/design/load.hpp"
#include "core/design/refused_on_bus.hpp"
#include "core/design/sense.hpp"
#include "core/design/unlinked.hpp"
#include "core/gates/plan.hpp"
#include "core/gates/relay_gate.hpp"
#include "core/model/members.hpp"
#include "core/model/text.hpp"
#include "core/model/topology.hpp"
#include "core/profiles/profile.hpp"

namespace mlcca::core {
namespace {

constexpr std::size_t kProgressStep = 1024;

class Inspector {
 public:
  Inspector(const System& system, const InspectProgress& progress, const EachDecided& each,
            InspectedBuses* buses)
      : s_(system),
        progress_(progress),
        each_(each),
        buses_(buses),
        unlinked_(system),
        topology_(system),
        members_(system),
        world_(described_world(system)),
        withdrawn_(system.channels.size(), false),
        reached_(system.networks.size(), false),
        ledger_(empty_ledger(system, world_)) {
    for (const Gateway& gateway : system.gateways)
      for (const Port& port : gateway.ports) reached_[port.network] = true;
  }

  Inspection run() {
    out_.channels.resize(s_.channels.size());
    check_networks();
    check_relays();
    add_sense_notes(s_, members_, out_.findings);
    const Situation situation{s_, topology_, members_, world_, withdrawn_, true};
    const bool plain = is_plain(s_);
    decide_each(situation, ledger_, [&](std::size_t channel, const Decision& decision) {
      note_best_cases(decision);
      // In a plain system only what was decided before can be in the way.
      if (plain && !has_best_cases_)
        examine(situation, channel, decision);
      else
        waiting_.emplace(channel, decision);
      if (progress_ && (channel + 1) % kProgressStep == 0) progress_(channel + 1);
    });
    if (has_best_cases_)
      for (const std::size_t c : Contest(situation).mark(waiting_))
        out_.channels[c].open_set = true;
    for (const auto& [channel, decision] : waiting_) examine(situation, channel, decision);
    report(situation);
    refused_on_bus_.report(s_, members_, ledger_, contested_.take(situation, ledger_),
                           out_.findings);
    unlinked_.report(out_.findings);
    if (buses_ != nullptr) report_buses(situation);
    for (std::size_t n = 0; n < s_.networks.size(); ++n)
      out_.networks.push_back(load_of(ledger_, world_, n));
    std::ranges::stable_sort(out_.findings, {}, [](const Finding& f) {
      return std::tuple(f.origin.file, f.origin.line, f.id);
    });
    remove_repeated(out_.findings);
    return std::move(out_);
  }

 private:
  void add(FindingId id, Origin origin, std::string text, std::string hint, std::size_t channel,
           std::uint32_t publisher = kNone, std::uint32_t subscriber = kNone) {
    Finding& f = out_.findings.emplace_back();
    f.id = id;
    f.origin = origin;
    f.text = std::move(text);
    f.hint = std::move(hint);
    f.channel = static_cast<std::uint32_t>(channel);
    f.publisher = publisher;
    f.subscriber = subscriber;
  }

  void examine(const Situation& situation, std::size_t channel, const Decision& decision) {
    const std::size_t before = out_.findings.size();
    check_channel(channel, decision, Explainer(situation, ledger_, out_.findings));
    for (const Verdict& v : decision.verdicts) {
      refused_on_bus_.add(v);
      unlinked_.add(situation, v);
    }
    contested_.add_contested(decision);
    if (buses_ != nullptr) messages_.add(situation, ledger_, decision);
    if (each_) keep(channel, decision, std::span(out_.findings).subspan(before));
  }

  void note_best_cases(const Decision& decision) {
    has_best_cases_ =
        has_best_cases_ || std::ranges::any_of(decision.verdicts, [](const Verdict& v) {
          return v.outcome == Outcome::run_time;
        });
  }

  struct Kept {
    std::size_t channel;
    Decision decision;
    std::vector<Finding> errors;
  };

  /// Removes findings with equal text at one line, which come from several endpoints of one place.
  static void remove_repeated(std::vector<Finding>& findings) {
    std::set<std::tuple<std::uint32_t, int, FindingId, std::string>> said;
    std::erase_if(findings, [&](const Finding& f) {
      return !said.emplace(f.origin.file, f.origin.line, f.id, f.text).second;
    });
  }

  static std::vector<Finding> errors_of(std::span<const Finding> findings) {
    std::vector<Finding> out;
    std::ranges::copy_if(findings, std::back_inserter(out),
                         [](const Finding& f) { return info(f.id).severity == Severity::error; });
    return out;
  }

  /// Keeps a decision until all are decided, if that can still change its numbers.
  void keep(std::size_t channel, const Decision& decision, std::span<const Finding> findings) {
    const bool waits =
        std::ranges::any_of(decision.verdicts, [](const Verdict& v) { return !v.media.empty(); });
    std::vector<Finding> errors = errors_of(findings);
    if (waits || sets_of(s_, channel) > 1)
      kept_.push_back({channel, decision, std::move(errors)});
    else
      each_(channel, decision, errors);
  }

  void report(const Situation& situation) {
    for (Kept& kept : kept_) {
      renew_responses(situation, ledger_, kept.decision);
      each_(kept.channel, kept.decision, kept.errors);
      for (std::size_t set = 0; set < sets_of(s_, kept.channel); ++set)
        if (set != kept.decision.set) report_other(situation, kept.channel, set);
    }
  }

  void report_other(const Situation& situation, std::size_t channel, std::size_t set) {
    const Ledger::Mark before = ledger_.mark();
    for (const std::size_t p : members_.publishers_of(channel)) ledger_.remove(p);
    Decision decision = decide_in(situation, channel, set, ledger_);
    renew_responses(situation, ledger_, decision);
    std::vector<Finding> findings;
    Explainer explain(situation, ledger_, findings);
    for (const Verdict& v : decision.verdicts) explain.add(v);
    each_(channel, decision, errors_of(findings));
    ledger_.roll_back(before);
  }

  void report_buses(const Situation& situation) {
    buses_->messages = messages_.take(situation, ledger_);
    find_varying(situation);
    for (std::size_t n = 0; n < s_.networks.size(); ++n) {
      const can::Schedule* bus = ledger_.schedule(n);
      buses_->assumptions.push_back(bus != nullptr ? std::optional(bus->assumptions())
                                                   : std::nullopt);
    }
    inherit_jitter(*buses_);
  }

  /// Finds the buses that channels may use whose attribute set or route depends on best cases.
  void find_varying(const Situation& situation) {
    buses_->varying.assign(s_.networks.size(), {});
    for (const auto& [c, decision] : waiting_) {
      const bool open = std::ranges::any_of(
          decision.verdicts, [](const Verdict& v) { return v.outcome == Outcome::run_time; });
      if (!open && !out_.channels[c].open_set) continue;
      for (const std::size_t n : networks_of_ways(situation, c)) buses_->varying[n].push_back(c);
    }
  }
  /// The networks between publishers and targets that have more than one attribute set or route.
  [[nodiscard]] std::set<std::size_t> networks_of_ways(const Situation& situation,
                                                       std::size_t c) const {
    std::set<std::size_t> networks;
    for (const std::size_t p : members_.publishers_of(c))
      for (const Target& target : targets_of(members_, c)) {
        const auto& routes = situation.topology.routes(members_.publisher(p).place, target.place);
        if (routes.size() < 2 && sets_of(s_, c) < 2) continue;
        for (const Route& route : routes)
          for (const Place place : route)
            if (place.kind == Place::Kind::network) networks.insert(place.index);
      }
    return networks;
  }

  void check_networks() {
    if (s_.networks.size() < 2) return;
    for (std::size_t n = 0; n < s_.networks.size(); ++n) {
      if (reached_[n]) continue;
      const Network& network = s_.networks[n];
      add(FindingId::unreachable_network, network.origin,
          "no gateway has a port on network " + network.name +
              ": nothing leads there from any other network",
          "add a <Port network=\"" + network.name + "\"> to a Gateway, or remove the network",
          kNone);
      out_.findings.back().place = {Place::Kind::network, n};
      out_.findings.back().has_place = true;
    }
  }

  void check_relays() {
    for (std::size_t n = 0; n < s_.networks.size(); ++n) {
      for (std::size_t g = 0; g < s_.gateways.size(); ++g) {
        const std::string problem = relay_problem(s_, n, g);
        if (problem.empty()) continue;
        add(FindingId::relay_gated, s_.gateways[g].port_on(n)->origin, problem,
            relay_hint(s_, n, g), kNone);
        out_.findings.back().place = {Place::Kind::gateway, g};
        out_.findings.back().has_place = true;
      }
    }
  }

  void check_channel(std::size_t c, const Decision& decision, Explainer explain) {
    const auto& verdicts = decision.verdicts;
    ChannelResult& result = out_.channels[c];
    result.deliveries = verdicts.size();
    result.set = decision.set;
    for (const Verdict& v : verdicts) result.outcome = worse(result.outcome, v.outcome);
    if (!is_complete(c)) result.outcome = Outcome::unfit;
    if (s_.channels[c].safe_side == SafeSide::deliver) check_safe_side(c, verdicts);
    if (verdicts.size() > 1) check_senders(c, verdicts);
    if (members_.publishers_of(c).size() > 1) check_shared_limits(c);
    check_room(c, verdicts, result);
    if (result.outcome == Outcome::fit && result.set == 0 && !result.open_set) return;
    for (const Verdict& v : verdicts) explain.add(v);
    if (result.outcome == Outcome::unfit) return;
    const bool any_fit =
        std::ranges::any_of(verdicts, [](const Verdict& v) { return v.outcome == Outcome::fit; });
    // If there is a note that the run time decides, it says enough.
    if (!result.open_set)
      explain.add_lower_set(c, result.set, any_fit ? Outcome::fit : Outcome::run_time);
    else if (result.outcome == Outcome::fit)
      explain.add_open_set(c);
  }

  bool is_complete(std::size_t c) {
    const EventChannel& channel = s_.channels[c];
    const auto& publishers = members_.publishers_of(c);
    const auto& subscribers = members_.subscribers_of(c);
    if (publishers.empty() && subscribers.empty())
      add(FindingId::unused_channel, channel.origin,
          "channel " + channel.name + " is neither published nor subscribed", "", c);
    if (publishers.empty())
      for (const std::size_t s : subscribers) {
        const Subscriber& subscriber = members_.subscriber(s);
        add(FindingId::no_publisher, subscriber.origin,
            subscriber.name + " subscribes channel " + channel.name + ", which nobody publishes",
            "add a <Publisher channel=\"" + channel.name + "\" …/>, or remove the subscription", c,
            kNone, static_cast<std::uint32_t>(s));
      }
    if (subscribers.empty())
      for (const std::size_t p : publishers) {
        const Publisher& publisher = members_.publisher(p);
        const std::string* const bus = analysed_bus(publisher.place);
        add(FindingId::unused_publisher, publisher.origin,
            publisher.name + " publishes channel " + channel.name + ", which nobody subscribes" +
                (bus == nullptr ? "" : ": its frames on " + *bus + " are counted nowhere"),
            "add a <Subscriber channel=\"" + channel.name + "\" …/>, or remove the publisher" +
                (bus == nullptr ? "" : ": deadlines there hold for sure only while it is silent"),
            c, static_cast<std::uint32_t>(p));
      }
    return !publishers.empty() || subscribers.empty();
  }

  /// The name of the bus at that place whose response times are analysed; null if there is none.
  [[nodiscard]] const std::string* analysed_bus(Place place) const {
    if (place.kind != Place::Kind::network) return nullptr;
    const Network& network = s_.networks[place.index];
    return can::timing_of(network).bitrate != 0 ? &network.name : nullptr;
  }

  /// Reports each bus on which one identifier would have a second sender, and names both senders.
  void check_senders(std::size_t c, const std::vector<Verdict>& verdicts) {
    Senders senders(s_, members_);
    std::set<std::size_t> said;
    std::vector<const Verdict*> granted_first;
    granted_first.reserve(verdicts.size());
    for (const Verdict& v : verdicts) granted_first.push_back(&v);
    std::ranges::stable_partition(granted_first,
                                  [](const Verdict* v) { return v->outcome != Outcome::unfit; });
    for (const Verdict* const v : granted_first) {
      const auto conflict = senders.conflict(v->publisher, v->route);
      senders.add(v->publisher, v->route);
      if (!conflict || s_.networks[conflict->network.index].kind != NetworkKind::can) continue;
      // Refused deliveries are examined too, so that their repair does not reveal the next mistake
      // only then. But a repaired delivery may take another route.
      const bool one_own = conflict->first >= kOwn || conflict->other >= kOwn;
      const bool certain =
          v->outcome != Outcome::unfit || v->obstacle == Obstacle::sender_twice || one_own;
      if (!certain || !said.insert(conflict->network.index).second) continue;
      const Publisher& p = members_.publisher(v->publisher);
      add(FindingId::sender_twice, p.origin,
          "events of channel " + s_.channels[c].name + " reach " +
              s_.networks[conflict->network.index].name + " over " +
              sender_words(p.origin, conflict->first) + " and over " +
              sender_words(p.origin, conflict->other) + ": two senders of one identifier",
          sender_hint(s_.networks[conflict->network.index].profile), c,
          static_cast<std::uint32_t>(v->publisher));
      out_.findings.back().place = conflict->network;
      out_.findings.back().has_place = true;
      out_.channels[c].outcome = Outcome::unfit;
    }
  }

  /// Reports publishers that share an address on a network whose frames carry the subject, because
  /// nothing else distinguishes them.
  void check_shared_limits(std::size_t c) {
    std::map<std::pair<std::size_t, Station>, std::size_t> alike;
    std::set<std::pair<std::size_t, Station>> said;
    for (const std::size_t number : members_.publishers_of(c)) {
      const Publisher& p = members_.publisher(number);
      if (p.place.kind != Place::Kind::network || !s_.networks[p.place.index].carries_subjects() ||
          !reached_[p.place.index])
        continue;
      const auto key = std::pair(p.place.index, p.station);
      const auto [first, fresh] = alike.try_emplace(key, number);
      if (fresh || !said.insert(key).second) continue;
      add(FindingId::shared_limit, p.origin,
          "gates on network " + s_.networks[p.place.index].name +
              " cannot distinguish publishers " + members_.publisher(first->second).name + " and " +
              p.name + " of channel " + s_.channels[c].name +
              ": what one sends too much is taken from what the other may send, and the silence of "
              "one is not reported while the other sends",
          p.station.is_wildcard()
              ? "state the address that each of them sends from (address=\"192.0.2.7\")"
              : "give each of them an address of its own",
          c, static_cast<std::uint32_t>(number));
    }
  }

  void check_room(std::size_t c, const std::vector<Verdict>& verdicts, ChannelResult& result) {
    for (std::size_t g = 0; g < s_.gateways.size(); ++g) {
      const auto lack = exceeds_capacity(s_, members_, c, verdicts, g);
      if (!lack) continue;
      result.outcome = Outcome::unfit;
      add(FindingId::too_many, s_.channels[c].origin,
          "channel " + s_.channels[c].name + ": " + *lack,
          "give some of them subjects of their own, or let them come by another network", c);
    }
  }

  /// Names a device for a finding at `here`: "publisher pb (line 6)".
  [[nodiscard]] std::string sender_words(Origin here, Device device) const {
    const bool own = device >= kOwn;
    const Origin there =
        own ? members_.publisher(device - kOwn).origin : s_.gateways[device].origin;
    std::string words = own ? "publisher " + members_.publisher(device - kOwn).name
                            : "gateway " + s_.gateways[device].name;
    if (there.line <= 0) return words;
    words += " (line " + std::to_string(there.line);
    if (there.file != here.file && there.file < s_.files.size())
      words += " of " + s_.files[there.file];
    return words + ")";
  }

  /// Reports events that must arrive to be safe and cross a gate, which drops what it does not
  /// know, also after a crash.
  void check_safe_side(std::size_t c, const std::vector<Verdict>& verdicts) {
    for (const Verdict& v : verdicts) {
      const auto gateway = std::ranges::find(v.route, Place::Kind::gateway, &Place::kind);
      if (gateway == v.route.end()) continue;
      const EventChannel& channel = s_.channels[c];
      add(FindingId::unsafe_drop, channel.origin,
          "events of channel " + channel.name +
              " must arrive to be safe, and cross the gate of gateway " + name_of(s_, *gateway) +
              ", which drops while in doubt",
          "turn it into a heart-beat whose silence is safe (safe-side=\"drop\"), or keep publisher "
          "and subscribers on one network",
          c);
      return;
    }
  }

  const System& s_;
  const InspectProgress& progress_;
  const EachDecided& each_;
  InspectedBuses* buses_;
  BusMessages messages_;
  BusMessages contested_;
  RefusedOnBus refused_on_bus_;
  UnlinkedMeshes unlinked_;
  std::vector<Kept> kept_;
  bool has_best_cases_ = false;
  std::map<std::size_t, Decision> waiting_;  ///< by channel: examined when all are decided
  Topology topology_;
  Members members_;
  World world_;
  std::vector<bool> withdrawn_;
  std::vector<bool> reached_;  ///< networks that gateways have ports on
  Ledger ledger_;
  Inspection out_;
};

/// How long the queues of gateways must be for all messages of a bus.
class QueueLengths {
 public:
  QueueLengths(const InspectedBuses& buses, std::size_t network) {
    for (const SentMessage& sent : all_sent(buses, network)) {
      const std::uint32_t queue = sent.message->message->queue;
      if (queue != can::kOwnQueue) queue_of_[sent.message->publisher] = queue;
      std::uint32_t& longest = longest_[queue];
      longest = std::max(longest, sent.response.bounded ? sent.response.queued_frames : kNone);
    }
  }
  /// The necessary length of the queue in which the publisher's frames wait; nullopt if there is no
  /// queue or no bound.
  [[nodiscard]] std::optional<std::uint32_t> of(std::size_t publisher) const {
    const auto queue = queue_of_.find(publisher);
    if (queue == queue_of_.end() || longest_.at(queue->second) == kNone) return std::nullopt;
    return longest_.at(queue->second);
  }

 private:
  std::map<std::size_t, std::uint32_t> queue_of_;
  std::map<std::uint32_t, std::uint32_t> longest_;  ///< by queue
};

/// Adapts the hints about short queues. Decisions one after the other state the length for the
/// messages before; the hints must state it for all.
void state_queue_lengths(const System& system, Inspection& inspection,
                         const InspectedBuses& buses) {
  std::map<std::size_t, QueueLengths> lengths;  // by network
  for (Finding& f : inspection.findings) {
    if (f.id != FindingId::queue_too_short || f.frames_of == kNone) continue;
    const QueueLengths& of_bus =
        lengths.try_emplace(f.place.index, buses, f.place.index).first->second;
    if (const auto longest = of_bus.of(f.frames_of))
      f.hint = queue_hint(*longest, "so many frames wait there at most if all messages of " +
                                        system.networks[f.place.index].name + " are sent");
  }
}

}  // namespace

std::vector<SentMessage> all_sent(const InspectedBuses& buses, std::size_t network) {
  const auto& assumptions = buses.assumptions[network];
  if (!assumptions) return {};
  std::vector<SentMessage> out;
  std::vector<can::Message> messages;
  for (const BusMessage& m : buses.messages) {
    if (m.network != network || !m.message) continue;
    out.push_back({&m, {}});
    messages.push_back(*m.message);
    messages.back().key = messages.size();
  }
  const auto responses = can::analyse(*assumptions, messages);
  for (std::size_t i = 0; i < out.size(); ++i) out[i].response = responses[i];
  return out;
}

Inspection inspect(const System& system, const InspectProgress& progress, const EachDecided& each,
                   InspectedBuses* buses) {
  Inspection inspection = Inspector(system, progress, each, buses).run();
  if (std::ranges::none_of(inspection.findings,
                           [](const Finding& f) { return f.id == FindingId::queue_too_short; }))
    return inspection;
  InspectedBuses own;
  if (buses == nullptr) static_cast<void>(Inspector(system, {}, {}, &own).run());
  state_queue_lengths(system, inspection, buses == nullptr ? own : *buses);
  return inspection;
}

}  // namespace mlcca::core
