// SPDX-License-Identifier: BSD-2-Clause
#include "core/inspect.hpp"

#include <algorithm>
#include <string>
#include <tuple>
#include <utility>

#include "core/admission.hpp"
#include "core/explain.hpp"
#include "core/members.hpp"
#include "core/text.hpp"
#include "core/topology.hpp"

namespace mlcca::core {
namespace {

constexpr std::size_t kProgressStep = 1024;

class Inspector {
 public:
  Inspector(const System& system, const InspectProgress& progress)
      : s_(system),
        progress_(progress),
        topology_(system),
        members_(system),
        conditions_(system.networks.size()),
        released_(system.channels.size(), false) {}

  Inspection run() {
    out_.channels.resize(s_.channels.size());
    check_networks();
    const Situation situation{s_, topology_, members_, conditions_, released_, true};
    const Ledger ledger = decide_each(
        situation,
        [&](std::size_t channel, const std::vector<Verdict>& verdicts, const Ledger& so_far) {
          check_channel(channel, verdicts, Explainer(situation, so_far, out_.findings));
          if (progress_ && (channel + 1) % kProgressStep == 0) progress_(channel + 1);
        });
    for (std::size_t n = 0; n < s_.networks.size(); ++n)
      out_.networks.push_back({ledger.reserved(n)});
    std::ranges::stable_sort(out_.findings, {}, [](const Finding& f) {
      return std::tuple(f.origin.file, f.origin.line, f.id);
    });
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

  void check_networks() {
    if (s_.networks.size() < 2) return;
    std::vector<bool> reached(s_.networks.size(), false);
    for (const Gateway& gateway : s_.gateways)
      for (const Port& port : gateway.ports) reached[port.network] = true;
    for (std::size_t n = 0; n < s_.networks.size(); ++n) {
      if (reached[n]) continue;
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

  void check_channel(std::size_t c, const std::vector<Verdict>& verdicts, Explainer explain) {
    ChannelResult& result = out_.channels[c];
    result.deliveries = verdicts.size();
    if (!verdicts.empty()) result.set = verdicts.front().set;
    for (const Verdict& v : verdicts) result.outcome = worse(result.outcome, v.outcome);
    if (!is_complete(c)) result.outcome = Outcome::unfit;
    if (s_.channels[c].safe_side == SafeSide::deliver) check_safe_side(c, verdicts);
    if (result.outcome == Outcome::fit && result.set == 0) return;
    for (const Verdict& v : verdicts) explain.add(v);
    if (result.outcome != Outcome::unfit && result.set != 0) explain.add_lower_set(c, result.set);
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
        add(FindingId::unused_publisher, publisher.origin,
            publisher.name + " publishes channel " + channel.name + ", which nobody subscribes",
            "add a <Subscriber channel=\"" + channel.name + "\" …/>, or remove the publisher", c,
            static_cast<std::uint32_t>(p));
      }
    return !publishers.empty() || subscribers.empty();
  }

  /// A gate drops what it does not know, after a crash too: a danger for what must arrive.
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
  Topology topology_;
  Members members_;
  std::vector<Condition> conditions_;
  std::vector<bool> released_;
  Inspection out_;
};

}  // namespace

Inspection inspect(const System& system, const InspectProgress& progress) {
  return Inspector(system, progress).run();
}

}  // namespace mlcca::core
