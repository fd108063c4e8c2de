// SPDX-License-Identifier: BSD-2-Clause
// Elements that the schema has accepted, into the structs of the draft.
#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <span>
#include <utility>

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

std::string text_of(const Element* element) { return element == nullptr ? "" : element->text; }

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

class PartReader {
 public:
  PartReader(Draft& draft, Problems& problems) : draft_(draft), problems_(problems) {}

  void add(const Element& part) {
    if (part.name == "EventChannel") draft_.channels.push_back(channel(part));
    if (part.name == "Network") draft_.networks.push_back(network(part));
    if (part.name == "Gateway") draft_.gateways.push_back(gateway(part));
    if (part.name == "Publisher") draft_.publishers.push_back(end(part));
    if (part.name == "Subscriber") draft_.subscribers.push_back(end(part));
  }

 private:
  [[nodiscard]] core::Origin origin(const Element& element) const {
    return {problems_.file(), element.line};
  }

  AttributeSet attributes(const Element& parent, std::string_view list, Side side) {
    const auto* element = parent.child(list);
    return element == nullptr ? AttributeSet{} : read_attributes(*element, side, problems_);
  }

  core::EventChannel channel(const Element& e) {
    return {.name = text_of(e, "name"),
            .subject = number<core::Subject>(text_of(e.child("SubjectUID"))),
            .description = text_of(e.child("Description")),
            .attributes = attributes(e, "Attributes", Side::requirement),
            .origin = origin(e)};
  }

  NetworkDraft network(const Element& e) {
    NetworkDraft out;
    out.network.name = text_of(e, "name");
    out.network.kind = value_named<NetworkKind>(text_of(e.child("Kind")), kKinds);
    out.network.profile = value_named<Profile>(text_of(e.child("Profile")), kProfiles);
    out.network.provision = attributes(e, "Provision", Side::provision);
    out.network.origin = origin(e);
    for (const auto& child : e.children)
      if (child.name == "Binding") out.bindings.push_back(binding(child));
    return out;
  }

  [[nodiscard]] BindingDraft binding(const Element& e) const {
    BindingDraft out;
    out.channel = text_of(e, "channel");
    const auto* etag = e.child("ETag");
    const auto* identifier = e.child("Identifier");
    out.etag = etag != nullptr;
    out.binding.id = number<std::uint32_t>(text_of(out.etag ? etag : identifier));
    out.binding.extended = out.etag || identifier->attribute("form") == "extended";
    out.binding.format = value_named<FrameFormat>(e.attribute("format"), kFormats);
    out.binding.remote_frames = is_true(e.attribute("remote-frames"));
    out.binding.origin = origin(e);
    return out;
  }

  GatewayDraft gateway(const Element& e) {
    GatewayDraft out;
    out.gateway.name = text_of(e, "name");
    out.gateway.host = text_of(e, "host");
    out.gateway.provision = attributes(e, "Provision", Side::provision);
    out.gateway.origin = origin(e);
    for (const auto& child : e.children)
      if (child.name == "Port") out.ports.push_back(port(child));
    return out;
  }

  [[nodiscard]] PortDraft port(const Element& e) const {
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
    out.port.origin = origin(e);
    return out;
  }

  EndDraft end(const Element& e) {
    return {.name = text_of(e, "name"),
            .channel = text_of(e, "channel"),
            .network = text_of(e, "network"),
            .gateway = text_of(e, "gateway"),
            .user = text_of(e, "user"),
            .node = optional_number(e.attribute("node")),
            .priority = optional_number(e.attribute("priority")),
            .own = attributes(e, "Attributes", Side::requirement),
            .origin = origin(e)};
  }

  Draft& draft_;
  Problems& problems_;
};

}  // namespace

void add_part(const Element& part, Draft& draft, Problems& problems) {
  PartReader(draft, problems).add(part);
}

}  // namespace mlcca::description
