// SPDX-License-Identifier: BSD-2-Clause
// Converts elements that the schema has accepted to the structs of the draft.
#include <fmt/format.h>

#include <cstdint>

#include "core/model/text.hpp"
#include "core/model/words.hpp"
#include "core/profiles/profile.hpp"
#include "description/attributes.hpp"
#include "description/convert.hpp"
#include "description/decimals.hpp"
#include "description/draft.hpp"
#include "description/media.hpp"

namespace mlcca::description {
namespace {

Composition composition_named(std::string_view word) {
  if (word == "maximum") return Composition::slowest;
  if (word == "minimum") return Composition::smallest;
  if (word == "survival") return Composition::survival;
  return Composition::sum;
}

class PartReader {
 public:
  PartReader(Draft& draft, Problems& problems) : draft_(draft), problems_(problems) {}

  void add(const Element& part) {
    if (part.name == "EventChannel") draft_.channels.push_back(channel(part));
    if (part.name == "Publisher") draft_.publishers.push_back(end(part));
    if (part.name == "Subscriber") draft_.subscribers.push_back(end(part));
    if (part.name == "Network") draft_.networks.push_back(network(part));
    if (part.name == "Gateway") draft_.gateways.push_back(gateway(part));
    if (part.name == "Component") add_component(part);
    if (part.name == "Placement") draft_.placements.push_back(placement(part));
    if (part.name == "Route") draft_.routes.push_back(route(part));
    if (part.name == "UserAttribute") draft_.user_attributes.push_back(user_attribute(part));
  }

 private:
  StatedDraft stated(const Element& list, Side side) {
    StatedDraft out;
    out.set = read_attributes(list, side, problems_, out.user);
    if (const auto priority = list.attribute("priority"); !priority.empty())
      out.priority = number<int>(priority);
    out.origin = list.origin();
    return out;
  }

  std::vector<StatedDraft> sets(const Element& parent) {
    std::vector<StatedDraft> out;
    for (const auto& child : parent.children)
      if (child.name == "Attributes") out.push_back(stated(child, Side::requirement));
    return out;
  }

  StatedDraft provision(const Element& parent) {
    const auto* list = parent.child("Provision");
    return list == nullptr ? StatedDraft{} : stated(*list, Side::provision);
  }

  ChannelDraft channel(const Element& e) {
    ChannelDraft out;
    out.channel.name = text_of(e, "name");
    out.channel.subject = number<core::Subject>(text_of(e.child("SubjectUID")));
    if (out.channel.name.empty()) out.channel.name = core::format_subject(out.channel.subject);
    out.channel.description = text_of(e.child("Description"));
    out.channel.safe_side = core::words::kSafeSides.or_first(e.attribute("safe-side"));
    out.channel.arrival = core::words::kArrivals.or_first(e.valued("arrival"));
    out.channel.importance = number_of<std::uint8_t>(e, "importance");
    out.channel.origin = e.origin();
    out.sets = sets(e);
    return out;
  }

  [[nodiscard]] static UserAttributeDraft user_attribute(const Element& e) {
    UserAttributeDraft out;
    out.dimension = read_dimension(e.child("Dimension"));
    out.attribute = {.name = text_of(e, "name"),
                     .better = core::words::kBetters.or_first(text_of(e.child("Better"))),
                     .composition = composition_named(text_of(e.child("Composition"))),
                     .unit = unit_words(out.dimension.unit),
                     .magnitude = out.dimension.magnitude,
                     .origin = e.origin()};
    return out;
  }

  NetworkDraft network(const Element& e) {
    NetworkDraft out;
    out.network.name = text_of(e, "name");
    out.network.kind = core::words::kNetworkKinds.or_first(text_of(e.child("Kind")));
    out.network.profile = core::words::kProfiles.or_first(text_of(e.child("Profile")));
    out.network.origin = e.origin();
    out.network.subscribe_tag = number<std::uint32_t>(text_of(e, "subscribe-etag"));
    out.network.states_subscribe_tag = e.has("subscribe-etag");
    out.control = control(e);
    if (const auto* bus = e.child("Bus")) {
      out.network.bus = read_bus(*bus, problems_);
      out.bus = bus->origin();
    }
    if (const auto* mesh = e.child("Mesh")) out.mesh = read_mesh(*mesh, problems_);
    out.provision = provision(e);
    if (const auto* unlisted = e.child("Unlisted")) out.network.unlisted = policy(*unlisted);
    if (const auto* some = e.child("Subscriptions"))
      out.network.subscriptions = {
          .accept = core::words::kSubscribings.or_first(some->valued("accept")),
          .most = number_of<std::uint32_t>(*some, "most"),
          .origin = some->origin()};
    for (const auto& child : e.children)
      if (child.name == "Binding") out.bindings.push_back(binding(child));
    return out;
  }

  [[nodiscard]] core::UnlistedPolicy policy(const Element& e) const {
    core::UnlistedPolicy out;
    const auto allow = e.valued("allow");
    out.most = number_of<std::uint32_t>(e, "most");
    if (allow == "no") return out;
    out.allowed = true;
    if (allow == "any") return out;
    const auto slash = allow.find('/');
    out.subject = number<core::Subject>(allow.substr(0, slash));
    out.bits = number<std::uint8_t>(allow.substr(slash + 1));
    if (const core::Subject leading = out.leading(); leading != out.subject)
      problems_.add(e.origin(), e.name,
                    fmt::format("attribute allow: {} has bits behind its leading {}, which count "
                                "for nothing: write 0x{:016x}/{}, or more bits",
                                allow, out.bits, leading, out.bits),
                    core::FindingId::rule);
    return out;
  }

  [[nodiscard]] static BindingDraft binding(const Element& e) {
    BindingDraft out;
    out.channel = text_of(e, "channel");
    out.binding.dynamic = is_true(e, "dynamic");
    out.binding.format = core::words::kFrameFormats.or_first(e.valued("format"));
    out.binding.remote_frames = is_true(e, "remote-frames");
    out.binding.origin = e.origin();
    if (e.children.empty()) {
      out.binding.extended = true;
      return out;
    }
    const auto& named = e.children.front();
    out.element = named.name;
    out.binding.id = number<std::uint32_t>(named.text);
    if (const auto priority = optional_number(named.attribute("priority")))
      out.binding.priority = static_cast<std::uint8_t>(*priority);
    out.destination = optional_number(named.attribute("destination"));
    out.binding.mask = number_or(named, "mask", out.binding.mask);
    const auto* const profile = core::profile_with_element(named.name);
    const auto form = profile == nullptr ? core::IdentifierForm::extended : profile->form;
    out.binding.extended = form == core::IdentifierForm::stated
                               ? named.attribute("form") == "extended"
                               : form == core::IdentifierForm::extended;
    return out;
  }

  GatewayDraft gateway(const Element& e) {
    GatewayDraft out;
    out.gateway.name = text_of(e, "name");
    out.gateway.host = text_of(e, "host");
    out.gateway.presence = decimal_of(e, "presence", problems_);
    out.gateway.forwarder = core::words::kForwarders.or_first(e.valued("forward"));
    out.gateway.origin = e.origin();
    out.provision = provision(e);
    for (const auto& child : e.children)
      if (child.name == "Port") out.ports.push_back(port(child));
    return out;
  }

  [[nodiscard]] static ControlDraft control(const Element& e) {
    return {.kinds = text_of(e, "control"),
            .rate = number_or<std::uint32_t>(e, "control-rate", 0),
            .user = text_of(e, "control-user")};
  }

  [[nodiscard]] static PortDraft port(const Element& e) {
    PortDraft out;
    out.network = text_of(e, "network");
    const auto* interface = e.child("Interface");
    out.port.identity = {.name = text_of(*interface, "name"),
                         .id_path = text_of(*interface, "id-path"),
                         .serial = text_of(*interface, "serial"),
                         .alias = text_of(*interface, "alias"),
                         .port = optional_number(interface->attribute("port"))};
    out.port.managed = is_true(e, "managed");
    out.port.bitrate = number<std::uint32_t>(text_of(e.child("Bitrate")));
    out.port.data_bitrate = number<std::uint32_t>(text_of(e.child("DataBitrate")));
    out.port.queueing = core::words::kQueueings.or_first(e.valued("queue"));
    out.port.fifo_depth = number_of<std::uint32_t>(e, "fifo-depth");
    out.port.queue_length = number_of<std::uint32_t>(e, "queue-length");
    out.port.excess = core::words::kExcesses.or_first(e.valued("excess"));
    out.port.refused = core::words::kRefusals.or_first(e.valued("refused"));
    out.port.origin = e.origin();
    out.control = control(e);
    out.node = optional_number(e.attribute("node"));
    out.sender = text_of(e, "sender");
    out.states_queue = e.has("queue") || e.has("fifo-depth") || e.has("queue-length");
    return out;
  }

  [[nodiscard]] static SeatDraft seat(const Element& e) {
    return {.network = text_of(e, "network"),
            .gateway = text_of(e, "gateway"),
            .mesh_node = text_of(e, "mesh-node"),
            .user = text_of(e, "user"),
            .address = text_of(e, "address"),
            .node = optional_number(e.attribute("node")),
            .priority = optional_number(e.attribute("priority"))};
  }

  EndDraft end(const Element& e, std::uint32_t component = core::kNoComponent) {
    return {.name = text_of(e, "name"),
            .channel = text_of(e, "channel"),
            .seat = seat(e),
            .component = component,
            .group = text_of(e, "group"),
            .unit = text_of(e, "unit"),
            .own = sets(e),
            .origin = e.origin()};
  }

  void add_component(const Element& e) {
    const auto number = static_cast<std::uint32_t>(draft_.components.size());
    auto& component = draft_.components.emplace_back();
    component.component.name = text_of(e, "name");
    component.component.description = text_of(e.child("Description"));
    component.component.origin = e.origin();
    component.seat = seat(e);
    for (const auto& child : e.children) {
      if (child.name == "EventChannel") draft_.channels.push_back(channel(child));
      if (child.name == "Publisher") draft_.publishers.push_back(end(child, number));
      if (child.name == "Subscriber") draft_.subscribers.push_back(end(child, number));
    }
  }

  [[nodiscard]] static PlacementDraft placement(const Element& e) {
    return {text_of(e, "component"), seat(e), e.origin()};
  }

  [[nodiscard]] static RouteDraft route(const Element& e) {
    RouteDraft out{{}, e.origin()};
    out.places.push_back({text_of(e, "from"), out.origin});
    for (const auto& hop : e.children) out.places.push_back({text_of(hop, "place"), hop.origin()});
    out.places.push_back({text_of(e, "to"), out.origin});
    return out;
  }

  Draft& draft_;
  Problems& problems_;
};

}  // namespace

void add_part(const Element& part, Draft& draft, Problems& problems) {
  PartReader(draft, problems).add(part);
}

}  // namespace mlcca::description
