// SPDX-License-Identifier: BSD-2-Clause
// Elements that the schema has accepted, into the structs of the draft.
#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <span>
#include <utility>

#include "core/text.hpp"
#include "description/attributes.hpp"
#include "description/draft.hpp"

namespace mlcca::description {
namespace {

/// Decimal, or hexadecimal after 0x; the schema has bounded the digits to what fits.
template <class Number>
Number number(std::string_view text) {
  int base = 10;
  if (text.starts_with("0x")) {
    base = 16;
    text.remove_prefix(2);
  } else if (text.starts_with('+')) {
    text.remove_prefix(1);
  }
  Number value = 0;
  std::from_chars(text.begin(), text.end(), value, base);
  return value;
}

std::optional<unsigned> optional_number(std::string_view text) {
  if (text.empty()) return std::nullopt;
  return number<unsigned>(text);
}

bool is_true(std::string_view text) { return text == "true" || text == "1"; }

std::string text_of(const Element* element) {
  return element == nullptr ? std::string() : std::string(element->text);
}

std::string text_of(const Element& element, std::string_view attribute) {
  return std::string(element.attribute(attribute));
}

template <class Enum>
Enum value_named(std::string_view name, std::span<const std::pair<std::string_view, Enum>> names) {
  const auto found = std::ranges::find_if(names, [&](const auto& n) { return n.first == name; });
  return found == names.end() ? names.front().second : found->second;
}

using core::FrameFormat;
using core::NetworkKind;
using core::Profile;

constexpr auto kKinds = std::to_array<std::pair<std::string_view, NetworkKind>>({
    {"can", NetworkKind::can},
    {"udp-multicast", NetworkKind::udp_multicast},
    {"mesh", NetworkKind::mesh},
    {"ieee802154", NetworkKind::ieee802154},
    {"other", NetworkKind::other},
});

// The first is what an absent element or attribute means.
constexpr auto kProfiles = std::to_array<std::pair<std::string_view, Profile>>({
    {"none", Profile::none},
    {"raw", Profile::raw},
    {"famouso", Profile::famouso},
});

constexpr auto kFormats = std::to_array<std::pair<std::string_view, FrameFormat>>({
    {"classic", FrameFormat::classic},
    {"fd", FrameFormat::fd},
    {"any", FrameFormat::any},
});

constexpr auto kSafeSides = std::to_array<std::pair<std::string_view, core::SafeSide>>({
    {"", core::SafeSide::unstated},
    {"drop", core::SafeSide::drop},
    {"deliver", core::SafeSide::deliver},
});

constexpr auto kBetters = std::to_array<std::pair<std::string_view, Better>>({
    {"smaller", Better::smaller},
    {"larger", Better::larger},
});

constexpr auto kCompositions = std::to_array<std::pair<std::string_view, Composition>>({
    {"sum", Composition::sum},
    {"maximum", Composition::slowest},
    {"minimum", Composition::smallest},
    {"survival", Composition::survival},
});

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
    out.channel.safe_side = value_named<core::SafeSide>(e.attribute("safe-side"), kSafeSides);
    out.channel.origin = e.origin();
    out.sets = sets(e);
    return out;
  }

  [[nodiscard]] static UserAttributeDraft user_attribute(const Element& e) {
    UserAttributeDraft out;
    out.dimension = read_dimension(e.child("Dimension"));
    out.attribute = {
        .name = text_of(e, "name"),
        .better = value_named<Better>(text_of(e.child("Better")), kBetters),
        .composition = value_named<Composition>(text_of(e.child("Composition")), kCompositions),
        .unit = unit_words(out.dimension.unit),
        .magnitude = out.dimension.magnitude,
        .origin = e.origin()};
    return out;
  }

  NetworkDraft network(const Element& e) {
    NetworkDraft out;
    out.network.name = text_of(e, "name");
    out.network.kind = value_named<NetworkKind>(text_of(e.child("Kind")), kKinds);
    out.network.profile = value_named<Profile>(text_of(e.child("Profile")), kProfiles);
    out.network.origin = e.origin();
    out.provision = provision(e);
    for (const auto& child : e.children)
      if (child.name == "Binding") out.bindings.push_back(binding(child));
    return out;
  }

  [[nodiscard]] static BindingDraft binding(const Element& e) {
    BindingDraft out;
    out.channel = text_of(e, "channel");
    const auto* etag = e.child("ETag");
    const auto* identifier = e.child("Identifier");
    out.etag = etag != nullptr;
    out.binding.id = number<std::uint32_t>(text_of(out.etag ? etag : identifier));
    out.binding.extended = out.etag || identifier->attribute("form") == "extended";
    out.binding.format = value_named<FrameFormat>(e.attribute("format"), kFormats);
    out.binding.remote_frames = is_true(e.attribute("remote-frames"));
    out.binding.origin = e.origin();
    return out;
  }

  GatewayDraft gateway(const Element& e) {
    GatewayDraft out;
    out.gateway.name = text_of(e, "name");
    out.gateway.host = text_of(e, "host");
    out.gateway.origin = e.origin();
    out.provision = provision(e);
    for (const auto& child : e.children)
      if (child.name == "Port") out.ports.push_back(port(child));
    return out;
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
    out.port.managed = is_true(e.attribute("managed"));
    out.port.bitrate = number<std::uint32_t>(text_of(e.child("Bitrate")));
    out.port.data_bitrate = number<std::uint32_t>(text_of(e.child("DataBitrate")));
    out.port.origin = e.origin();
    return out;
  }

  [[nodiscard]] static SeatDraft seat(const Element& e) {
    return {.network = text_of(e, "network"),
            .gateway = text_of(e, "gateway"),
            .user = text_of(e, "user"),
            .node = optional_number(e.attribute("node")),
            .priority = optional_number(e.attribute("priority"))};
  }

  EndDraft end(const Element& e, std::uint32_t component = core::kNoComponent) {
    return {.name = text_of(e, "name"),
            .channel = text_of(e, "channel"),
            .seat = seat(e),
            .component = component,
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
