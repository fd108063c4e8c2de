// SPDX-License-Identifier: BSD-2-Clause
// Reads the CAN networks of a description, with the decisions of a check.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/admission/world.hpp"
#include "core/can/of_system.hpp"
#include "core/design/inspect.hpp"
#include "core/mesh/roles.hpp"
#include "core/model/medium.hpp"
#include "core/model/text.hpp"
#include "core/profiles/profile.hpp"
#include "description/kinds.hpp"
#include "description/read.hpp"
#include "tools/design/analyse_bus/bus.hpp"

namespace mlcca::tools::design {
namespace {

using core::NetworkKind;
using core::Place;
using core::Publisher;
using core::System;

/// Replaces values of the description by those of the command line.
void state(core::CanBus& bus, const BusOptions& options) {
  if (options.bitrate != 0) bus.bitrate = options.bitrate;
  if (options.data_bitrate != 0) bus.data_bitrate = options.data_bitrate;
  if (options.unknown_senders) bus.unknown_senders = true;
  if (options.background) bus.background = *options.background;
  if (options.faults) bus.faults = *options.faults;
}

bool states_anything(const BusOptions& options) {
  return options.bitrate != 0 || options.data_bitrate != 0 || options.unknown_senders ||
         options.background || options.faults;
}

class DescribedBuses {
 public:
  DescribedBuses(System system, const BusOptions& options)
      : system_(std::move(system)), options_(options) {
    for (core::Network& network : system_.networks)
      if (is_wanted(network)) state(network.bus, options);
  }

  Buses read() && {
    if (std::ranges::none_of(system_.networks, [&](const auto& n) { return is_wanted(n); }))
      problem({}, options_.network.empty()
                      ? "no CAN network: there is nothing to analyse"
                      : fmt::format("no CAN network '{}': --network must name one of the system",
                                    options_.network));
    if (!problems_.empty()) return {{}, std::move(problems_)};
    inspection_ = core::inspect(system_, {}, {}, &inspected_);
    for (std::size_t n = 0; n < system_.networks.size(); ++n)
      if (is_wanted(system_.networks[n])) add_network(n);
    const auto is_analysed = [](const Bus& bus) { return bus.why_not.empty(); };
    if (std::ranges::any_of(buses_, is_analysed)) return {std::move(buses_), {}};
    for (Bus& bus : buses_) std::ranges::move(bus.why_not, std::back_inserter(problems_));
    return {{}, std::move(problems_)};
  }

 private:
  [[nodiscard]] bool is_wanted(const core::Network& network) const {
    return network.kind == NetworkKind::can &&
           (options_.network.empty() || network.name == options_.network);
  }

  [[nodiscard]] std::string where(core::Origin origin) const {
    const auto& files = system_.files;
    std::string file;
    if (!files.empty()) file = origin.file < files.size() ? files[origin.file] : files.front();
    return origin.line > 0 ? fmt::format("{}:{}", file, origin.line) : file;
  }
  [[nodiscard]] std::string at(core::Origin origin, const std::string& text) const {
    return fmt::format("{}: {}", where(origin), text);
  }
  void problem(core::Origin origin, const std::string& text) {
    problems_.push_back(at(origin, text));
  }

  void add_network(std::size_t n) {
    const core::Network& network = system_.networks[n];
    Bus bus;
    bus.network = network.name;
    bus.has_options = states_anything(options_);
    if (network.bus.bitrate == 0) {
      bus.why_not.push_back(
          at(network.origin,
             fmt::format("the bit rate of network {} is not described: state it with --bitrate",
                         network.name)));
      buses_.push_back(std::move(bus));
      return;
    }
    bus.assumptions = *inspected_.assumptions[n];
    for (const core::BusMessage& m : inspected_.messages)
      if (m.network == n) add_message(bus, m);
    name_ways(bus);
    std::ranges::move(clashes_on(n, bus), std::back_inserter(bus.why_not));
    add_lacking(bus);
    add_varying(n, bus);
    for (const core::Finding& f : inspection_.findings) {
      if (f.id == core::FindingId::unused_publisher && is_on(f.publisher, n)) {
        bus.left_out.push_back(f.text);
        bus.uncounted.push_back(uncounted(f.publisher, n, bus.assumptions.timing));
      }
      const bool about_bus =
          f.id == core::FindingId::deadline_missed || f.id == core::FindingId::queue_too_short;
      if (about_bus && f.has_place && f.place == Place{Place::Kind::network, n})
        bus.findings.push_back(
            fmt::format("{}: {}: {}", where(f.origin), core::code_of(f.id), f.text));
    }
    buses_.push_back(std::move(bus));
  }

  /// Conflicts of names and identifiers on a bus; if check found some, in its words.
  [[nodiscard]] std::vector<std::string> clashes_on(std::size_t n, const Bus& bus) const {
    if (problems_of(bus.messages, bus.network).empty()) return {};
    std::vector<std::string> said;
    for (const core::Finding& f : inspection_.findings)
      if (f.id == core::FindingId::sender_twice && f.has_place &&
          f.place == Place{Place::Kind::network, n})
        said.push_back(at(f.origin, core::code_of(f.id) + ": " + f.text));
    if (!said.empty()) return said;
    // Messages that are dropped before the bus have no identifier there.
    std::vector<BusMessage> there;
    std::ranges::copy_if(bus.messages, std::back_inserter(there),
                         [](const BusMessage& m) { return m.standing.counted; });
    return problems_of(there, bus.network);
  }

  [[nodiscard]] bool is_on(std::size_t publisher, std::size_t network) const {
    return system_.publishers[publisher].place == Place{Place::Kind::network, network};
  }

  [[nodiscard]] std::optional<core::can::Message> uncounted(std::size_t publisher,
                                                            std::size_t network,
                                                            const core::can::Timing& timing) const {
    const Publisher& p = system_.publishers[publisher];
    auto message = core::can::message_of(system_, p, 0, network, timing);
    if (message) message->jitter = p.attributes[Attribute::jitter];
    return message;
  }

  /// Notes which channels may have another form at run time than the analysed messages.
  void add_varying(std::size_t n, Bus& bus) const {
    bus.known = core::known_of(inspected_, n);
    if (!inspected_.guarded[n] && bus.known != core::Known::all) bus.sure = false;
    for (const std::size_t c : inspected_.varying[n])
      bus.unknown.push_back(fmt::format(
          "which attribute set or which way channel {} uses is decided at run time: it counts as "
          "if all best cases hold",
          system_.channels[c].name));
  }

  /// Notes what is not known about messages. A bus without messages cannot be analysed then.
  void add_lacking(Bus& bus) {
    for (const auto& [text, standing] : std::exchange(lacking_, {})) {
      if (bus.messages.empty()) {
        bus.why_not.push_back(text);
      } else if (standing.counted) {
        bus.unknown.push_back(text + "; it counts as nothing");
        bus.sure = bus.sure && standing.admitted;
      } else {
        bus.left_out.push_back(text +
                               "; mlccactl check refuses it, and it does not come to this bus");
      }
    }
  }

  void add_message(Bus& bus, const core::BusMessage& from) {
    const Publisher& p = system_.publishers[from.publisher];
    const core::Network& network = system_.networks[from.network];
    const core::Binding* binding = network.binding_of(p.channel);
    if (!from.message || binding == nullptr) {
      const bool of_network = lacks_data_rate(network, binding);
      lacking_.emplace_back(
          at(of_network ? network.origin : p.origin, why_not(p, network, binding)),
          core::standing_of(inspected_, from));
      return;
    }
    const AttributeSet& offered = core::attributes_in(p, from.set);
    BusMessage m;
    m.name = p.name;
    m.where = where(p.origin);
    const auto identifier =
        core::can::identifier_of(p, network, *binding, from.message->frames > 1);
    m.id = identifier->id;
    m.extended = identifier->extended;
    m.tag_known = !binding->waits_for_tag();
    if (offered.has(Attribute::max_payload)) m.bytes = offered[Attribute::max_payload];
    m.granted = from.outcome == Outcome::fit;
    m.outcome = from.outcome;
    m.held = from.held;
    m.present = from.present;
    m.several = from.several;
    m.standing = core::standing_of(inspected_, from);
    if (from.granted_response && *from.granted_response != core::can::kNever) {
      m.granted_response = from.granted_response;
      m.granted_on_bus = *from.granted_response - from.granted_jitter;
    }
    m.refused_response = from.refused_response;
    m.refused_jitter = from.refused_jitter;
    m.refused_frames = from.refused_frames;
    m.in_vain = from.in_vain;
    m.from_elsewhere = from.from != core::Flow::kOwn;
    m.message = *from.message;
    m.beside = from.sent;
    m.unbounded_on = unbounded_before(from);
    m.message.key = core::Ledger::key_of({from.publisher, from.network, from.from});
    if (m.beside) m.beside->key = m.message.key;
    froms_.push_back(from.from);
    if (m.standing.counted && !m.standing.admitted && !from.unknown.empty()) bus.sure = false;
    for (const Place place : from.unknown)
      bus.unknown.push_back(fmt::format("how long {} delays events of {} is not known{}",
                                        core::name_of(system_, place), p.name,
                                        counted_instead(place)));
    bus.messages.push_back(std::move(m));
  }

  [[nodiscard]] static bool lacks_data_rate(const core::Network& network,
                                            const core::Binding* binding) {
    return binding != nullptr && binding->format != core::FrameFormat::classic &&
           network.bus.data_bitrate == 0;
  }

  /// The first bus on the way before where the message has no bound, if its jitter here has none
  /// because of that; otherwise empty.
  [[nodiscard]] std::string unbounded_before(const core::BusMessage& from) const {
    std::string name;
    for (const core::BusMessage* m = &from;
         m != nullptr && m->sent && m->before && m->sent->jitter == core::can::kNever;
         m = message_before(*m))
      name = system_.networks[m->before->network].name;
    return name;
  }
  [[nodiscard]] const core::BusMessage* message_before(const core::BusMessage& m) const {
    const auto before = std::ranges::find_if(inspected_.messages, [&](const auto& other) {
      return other.network == m.before->network && other.publisher == m.publisher &&
             other.from == m.before->from;
    });
    return before == inspected_.messages.end() ? nullptr : &*before;
  }

  /// The value that is used for a delay at `place` that is not known.
  [[nodiscard]] std::string_view counted_instead(Place place) const {
    const bool network = place.kind == Place::Kind::network;
    const core::mesh::Mesh* const mesh = network && system_.networks[place.index].mesh
                                             ? &*system_.networks[place.index].mesh
                                             : nullptr;
    const AttributeSet& whole =
        network ? system_.networks[place.index].provision : system_.gateways[place.index].provision;
    const AttributeSet& stated = mesh != nullptr ? mesh->per_hop : whole;
    if (mesh != nullptr && mesh->links.empty() &&
        std::ranges::none_of(mesh->sources, core::mesh::knows_rates))
      return ", and counts as nothing: no Source knows the rates of its links";
    if (stated.has(Attribute::latency))
      return mesh != nullptr ? " before the run time, and counts as that of one link (PerHop)"
                             : " before the run time, and counts as its best case";
    return mesh != nullptr ? " and counts as nothing: state the Latency of a link (PerHop)"
                           : " and counts as nothing: state its Latency";
  }

  /// Appends the way to the names of messages if events of one publisher come by several ways.
  void name_ways(Bus& bus) {
    const std::size_t first = froms_.size() - bus.messages.size();
    std::vector<std::string> names;
    for (std::size_t i = 0; i < bus.messages.size(); ++i) {
      const BusMessage& m = bus.messages[i];
      const bool twice = std::ranges::count(bus.messages, m.name, &BusMessage::name) > 1;
      const std::size_t from = froms_[first + i];
      names.push_back(twice && from != core::Flow::kOwn
                          ? fmt::format("{} over {}", m.name, resource_name(from))
                          : m.name);
    }
    for (std::size_t i = 0; i < names.size(); ++i) bus.messages[i].name = names[i];
  }
  [[nodiscard]] std::string resource_name(std::size_t resource) const {
    for (std::size_t g = 0; g < system_.gateways.size(); ++g)
      if (system_.resource_of({Place::Kind::gateway, g}) == resource)
        return system_.gateways[g].name;
    return "a network";
  }

  [[nodiscard]] std::string why_not(const Publisher& p, const core::Network& network,
                                    const core::Binding* binding) const {
    const auto& channel = system_.channels[p.channel].name;
    if (binding == nullptr)
      return fmt::format("channel {} has no Binding on network {}: its frames are not known",
                         channel, network.name);
    if (lacks_data_rate(network, binding))
      return fmt::format(
          "frames of channel {} are not all classic, and {} has no bit rate for their data phase: "
          "state it with --data-bitrate",
          channel, network.name);
    if (!p.attributes.has(Attribute::period))
      return fmt::format(
          "publisher {} states no Period: how often it sends on network {} must be "
          "bounded",
          p.name, network.name);
    if (!core::names_channels(network.profile))
      return fmt::format("network {} has no Profile: the identifier of publisher {} is not known",
                         network.name, p.name);
    if (core::can_send(p, network))
      return fmt::format("what publisher {} sends is not known: state its MaxPayload", p.name);
    return fmt::format("publisher {} has no node of network {}: its identifier there is not known",
                       p.name, network.name);
  }

  System system_;
  const BusOptions& options_;
  core::Inspection inspection_;
  core::InspectedBuses inspected_;
  std::vector<std::size_t> froms_;  ///< for each message the index of its origin, see core::Flow
  /// Texts about messages of the present bus that are not known, and whether they count.
  std::vector<std::pair<std::string, core::Standing>> lacking_;
  std::vector<Bus> buses_;
  std::vector<std::string> problems_;
};

}  // namespace

Buses read_description(const std::string& file, const BusOptions& options) {
  auto examined = description::examine({file}, {}, description::Users::any);
  if (!examined.problems.empty() || !examined.readable) {
    Buses none;
    for (const auto& problem : description::shortened(examined.problems))
      none.problems.push_back(to_string(problem));
    return none;
  }
  examined.system.sort_bindings();
  return DescribedBuses(std::move(examined.system), options).read();
}

}  // namespace mlcca::tools::design
