// SPDX-License-Identifier: BSD-2-Clause
#include "core/design/sense.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "core/model/carrier.hpp"
#include "core/model/text.hpp"
#include "mlcca/check.hpp"

namespace mlcca::core {
namespace {

class Sense {
 public:
  Sense(const System& system, const Members& members, std::vector<Finding>& to)
      : s_(system), members_(members), to_(to) {}

  void channel(std::size_t c) {
    const EventChannel& channel = s_.channels[c];
    if (channel.safe_side == SafeSide::unstated) return;
    if (channel.safe_side == SafeSide::drop) heart_beat(c);
    for (const std::size_t p : members_.publishers_of(c))
      if (long_period(c, members_.publisher(p), static_cast<std::uint32_t>(p), kNone)) return;
    for (const std::size_t s : members_.subscribers_of(c))
      if (long_period(c, members_.subscriber(s), kNone, static_cast<std::uint32_t>(s))) return;
  }

  void port(std::size_t g, const Port& port) {
    const Gateway& gateway = s_.gateways[g];
    const Network& network = s_.networks[port.network];
    const std::string where = "the port of gateway " + gateway.name + " on " + network.name;
    if (port.managed && network.kind != NetworkKind::can)
      at_gateway(g, add(FindingId::managed_in_vain, port.origin,
                        where + " is managed, and " + network.name +
                            " is no CAN network: mlccad brings the interface up, and sets no "
                            "address and no rate",
                        "let the network configuration of the machine set the interface up, and "
                        "remove managed"));
    if (port.sender && is_sender_used(gateway, port))
      at_gateway(g,
                 add(FindingId::unstarted_sender, port.origin,
                     where + " leaves events to the program of its sender, which mlccad does not "
                             "start: without it they are granted, and none arrives",
                     std::string("let systemd start that program (a unit with User=), or ") +
                         (gateway.forwarder == Forwarder::relay
                              ? "remove sender: then mlcca-relay carries them"
                              : "state forward=\"relay\" in place of sender: then mlcca-relay "
                                "carries them")));
  }

 private:
  /// Whether a program must carry events from another port of the gateway to this one.
  [[nodiscard]] bool is_sender_used(const Gateway& gateway, const Port& port) const {
    return std::ranges::any_of(gateway.ports, [&](const Port& from) {
      return from.network != port.network &&
             !are_joined_by_kernel(gateway, s_.networks[from.network], s_.networks[port.network]);
    });
  }

  Finding& add(FindingId id, Origin origin, std::string text, std::string hint) {
    Finding& f = to_.emplace_back();
    f.id = id;
    f.origin = origin;
    f.text = std::move(text);
    f.hint = std::move(hint);
    return f;
  }

  static void at_gateway(std::size_t g, Finding& f) {
    f.place = {Place::Kind::gateway, g};
    f.has_place = true;
  }

  /// Notes subscribers that do not state how many events may be missing. Their silence is never
  /// reported.
  void heart_beat(std::size_t c) {
    for (const std::size_t p : members_.publishers_of(c))
      for (const std::size_t s : members_.subscribers_of(c)) {
        const Publisher& from = members_.publisher(p);
        const Subscriber& to = members_.subscriber(s);
        const AttributeSet asked =
            requirement_between(attributes_in(from, 0), attributes_in(to, 0));
        if (!asked.has(Attribute::period) || asked.has(Attribute::omission)) continue;
        Finding& f =
            add(FindingId::no_omission, to.origin,
                from.name + " to " + to.name + ": silence of channel " + s_.channels[c].name +
                    " is the safe state, and no Omission says when it is reported to " + to.name +
                    " that the events stay out",
                "state the Omission of " + to.name +
                    ", the events in a row that may be lost: 2, for example");
        f.channel = static_cast<std::uint32_t>(c);
        f.publisher = static_cast<std::uint32_t>(p);
        f.subscriber = static_cast<std::uint32_t>(s);
        f.attribute = info(Attribute::omission).name;
        return;
      }
  }

  template <class End>
  bool long_period(std::size_t c, const End& end, std::uint32_t publisher,
                   std::uint32_t subscriber) {
    const AttributeSet& stated = attributes_in(end, 0);
    if (!stated.has(Attribute::period) || stated[Attribute::period] < kLongPeriod ||
        stated[Attribute::period] == kUnbounded)
      return false;
    const std::string period = format_value(Attribute::period, stated[Attribute::period]);
    Finding& f =
        add(FindingId::long_period, end.origin,
            end.name + " states a Period of " + period + " on channel " + s_.channels[c].name +
                ", on which safety depends: a failure is noticed after (Omission + 1) Periods at "
                "the earliest",
            "look at the unit of the Period: heart-beats mostly have milliseconds");
    f.channel = static_cast<std::uint32_t>(c);
    f.publisher = publisher;
    f.subscriber = subscriber;
    f.attribute = info(Attribute::period).name;
    f.required = period;
    return true;
  }

  const System& s_;
  const Members& members_;
  std::vector<Finding>& to_;
};

}  // namespace

void add_sense_notes(const System& system, const Members& members, std::vector<Finding>& to) {
  Sense sense(system, members, to);
  for (std::size_t c = 0; c < system.channels.size(); ++c) sense.channel(c);
  for (std::size_t g = 0; g < system.gateways.size(); ++g)
    for (const Port& port : system.gateways[g].ports) sense.port(g, port);
}

}  // namespace mlcca::core
