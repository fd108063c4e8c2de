// SPDX-License-Identifier: BSD-2-Clause
// Checks the values of <Bus> and <Mesh> against their ranges, and a Source against its kind.
// mesh.cc resolves the names of nodes.
#include "description/media.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/un.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <utility>
#include <vector>

#include "base/decimal.hpp"
#include "base/number.hpp"
#include "core/model/words.hpp"
#include "description/convert.hpp"
#include "description/decimals.hpp"
#include "description/suggest.hpp"
#include "description/values.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::description {
namespace {

using core::FindingId;
using core::mesh::SourceKind;

template <class Number>
Number decimal(const Element& e, std::string_view attribute, Problems& problems) {
  return static_cast<Number>(decimal_of(e, attribute, problems));
}

// --- addresses -----------------------------------------------------------------------------------

bool is_mac(std::string_view text) {
  constexpr std::size_t length = 17;  // of "02:00:00:00:00:01"
  if (text.size() != length) return false;
  for (std::size_t i = 0; i < length; ++i)
    if (i % 3 == 2 ? text[i] != ':' : std::isxdigit(static_cast<unsigned char>(text[i])) == 0)
      return false;
  return true;
}

template <class Binary>
std::optional<std::string> normal_ip(int family, const std::string& text) {
  Binary binary{};
  std::array<char, INET6_ADDRSTRLEN> out{};
  if (inet_pton(family, text.c_str(), &binary) != 1) return std::nullopt;
  if (inet_ntop(family, &binary, out.data(), out.size()) == nullptr) return std::nullopt;
  return out.data();
}

bool is_port(std::string_view text) { return number_in<std::uint16_t>(text).value_or(0) != 0; }

/// Whether the text is like "127.0.0.1:33123" or "[::1]:33123".
bool is_host_and_port(std::string_view text) {
  const auto colon = text.rfind(':');
  if (colon == std::string_view::npos || !is_port(text.substr(colon + 1))) return false;
  const std::string host(text.substr(0, colon));
  if (host.size() > 2 && host.front() == '[' && host.back() == ']')
    return normal_ip<in6_addr>(AF_INET6, host.substr(1, host.size() - 2)).has_value();
  return normal_ip<in_addr>(AF_INET, host).has_value();
}

bool is_socket_path(std::string_view text) {
  return text.starts_with('/') && text.size() < sizeof(sockaddr_un::sun_path);
}

// --- sources -------------------------------------------------------------------------------------

bool has_interface(SourceKind kind) {
  return kind == SourceKind::nl80211 || kind == SourceKind::batman || kind == SourceKind::awds ||
         kind == SourceKind::wire;
}

bool has_endpoint(SourceKind kind) {
  return kind == SourceKind::file || kind == SourceKind::babel || kind == SourceKind::olsr;
}

/// What an endpoint of that kind must be; empty if it is right.
std::string_view right_endpoint(SourceKind kind, std::string_view endpoint) {
  if (kind == SourceKind::file)
    return endpoint.starts_with('/') ? "" : "the absolute path of a file of links";
  if (is_socket_path(endpoint)) return {};
  if (kind == SourceKind::awds) return "the absolute path of a socket (up to 107 bytes)";
  return is_host_and_port(endpoint) ? ""
                                    : "127.0.0.1:33123, [::1]:33123 or the absolute path of a "
                                      "socket (up to 107 bytes)";
}

/// Reports attributes that the kind of source needs and does not state, or states and does not
/// have.
void check_source(const Element& e, SourceKind kind, Problems& problems) {
  const auto name = e.attribute("kind");
  const auto check = [&](std::string_view attribute, bool known, bool needed) {
    if (needed && !e.has(attribute))
      problems.add(e.origin(), e.name,
                   fmt::format("attribute {} is missing: kind {} needs it", attribute, name));
    if (known || !e.has(attribute)) return;
    problems.add(e.origin(), e.name,
                 fmt::format("attribute {} is not for kind {}: remove it", attribute, name),
                 FindingId::wrong_place);
  };
  const bool awds = kind == SourceKind::awds;
  check("interface", has_interface(kind), has_interface(kind));
  check("endpoint", has_endpoint(kind) || awds, has_endpoint(kind));
  check("metric", awds, false);
  if (!e.has("endpoint") || !(has_endpoint(kind) || awds)) return;
  const auto endpoint = e.attribute("endpoint");
  if (const auto right = right_endpoint(kind, endpoint); !right.empty())
    problems.add(e.origin(), e.name,
                 fmt::format("attribute endpoint: '{}' is not right: {}", endpoint, right),
                 FindingId::not_in_schema);
}

core::mesh::Source source(const Element& e, Problems& problems) {
  const auto kind = core::words::kSourceKinds.or_first(e.attribute("kind"));
  check_source(e, kind, problems);
  return {.kind = kind,
          .interface = text_of(e, "interface"),
          .endpoint = text_of(e, "endpoint"),
          .metric = core::words::kAwdsMetrics.or_first(e.attribute("metric")),
          .origin = e.origin()};
}

// --- parts of a mesh
// ------------------------------------------------------------------------------

/// Whether PerHop may state the attribute: not those that follow from the links or that nobody
/// provides.
bool is_per_hop(Attribute a) {
  return a != Attribute::bandwidth && a != Attribute::max_payload && a != Attribute::deadline;
}

std::string per_hop_words(std::string_view name) {
  std::vector<std::string_view> names;
  std::string list;
  for (std::size_t i = 0; i < kAttributes; ++i) {
    if (!is_per_hop(attribute_at(i))) continue;
    names.emplace_back(info(attribute_at(i)).name);
    list += fmt::format("{}{}", list.empty() ? "" : ", ", names.back());
  }
  const auto close = closest(name, names);
  return fmt::format("'{}' is not one of {}{}", name, list,
                     close.empty() ? "" : fmt::format("; did you mean {}?", close));
}

StatedDraft per_hop(const Element& list, Problems& problems) {
  StatedDraft out;
  out.set = read_attributes(list, Side::provision, problems, out.user);
  for (const auto& user : out.user)
    problems.add(user.origin, "Name", per_hop_words(user.name), FindingId::unknown_name);
  out.user.clear();
  for (const auto& element : list.children) {
    const auto* name = element.child("Name");
    for (const auto a : {Attribute::bandwidth, Attribute::max_payload})
      if (name != nullptr && name->text == info(a).name)
        problems.add(element.origin(), element.name, of_links_words(name->text),
                     FindingId::wrong_place);
  }
  out.set.clear(Attribute::bandwidth);
  out.set.clear(Attribute::max_payload);
  out.origin = list.origin();
  return out;
}

MeshNodeDraft node(const Element& e, Problems& problems) {
  MeshNodeDraft out;
  out.node.name = text_of(e, "name");
  out.node.origin = e.origin();
  out.gateway = text_of(e, "gateway");
  const auto text = e.attribute("address");
  const auto address = normal_address(text);
  if (!address)
    problems.add(e.origin(), e.name,
                 fmt::format("attribute address: {}", explain(type::kNodeAddress, text)),
                 FindingId::not_in_schema);
  out.node.address = address.value_or("");
  return out;
}

NodePairDraft ends(const Element& e) {
  return {.from = text_of(e, "from"), .to = text_of(e, "to"), .origin = e.origin()};
}

MeshLinkDraft link(const Element& e, Problems& problems) {
  MeshLinkDraft out;
  out.ends = ends(e);
  out.link.rate = number<Value>(e.attribute("rate"));
  out.link.loss = decimal<Value>(e, "loss", problems);
  out.link.channel = number_of<std::uint32_t>(e, "channel");
  out.link.kind = core::words::kRateKinds.or_first(e.valued("kind"));
  out.link.origin = e.origin();
  out.both_ways = is_true(e, "both-ways");
  return out;
}

MeshDomainDraft domain(const Element& e) {
  MeshDomainDraft out;
  out.domain.name = text_of(e, "name");
  out.domain.origin = e.origin();
  for (const auto& member : e.children) out.members.push_back(ends(member));
  return out;
}

}  // namespace

std::optional<std::string> normal_address(std::string_view address) {
  std::string text(address);
  if (is_mac(address)) {
    std::ranges::transform(text, text.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
  }
  if (auto ip = normal_ip<in_addr>(AF_INET, text)) return ip;
  return normal_ip<in6_addr>(AF_INET6, text);
}

core::CanBus read_bus(const Element& e, Problems& problems) {
  core::CanBus out;
  out.bitrate = number<std::uint32_t>(e.attribute("bitrate"));
  out.data_bitrate = number_or<std::uint32_t>(e, "data-bitrate", 0);
  out.unknown_senders = is_true(e, "unknown-senders");
  out.measured = is_true(e, "measured");
  out.background = decimal<std::uint32_t>(e, "background-load", problems);
  out.faults.count = number_or<std::uint32_t>(e, "errors", 0);
  out.faults.interval = decimal<Value>(e, "error-interval", problems);
  if (out.data_bitrate != 0 && out.data_bitrate < out.bitrate)
    problems.add(
        e.origin(), e.name,
        fmt::format("data-bitrate {} is below bitrate {}: the data phase is not the slower "
                    "one",
                    out.data_bitrate, out.bitrate));
  if (e.has("errors") != e.has("error-interval"))
    problems.add(e.origin(), e.name,
                 fmt::format("attribute {} is missing: errors are so many in an error-interval",
                             e.has("errors") ? "error-interval" : "errors"));
  return out;
}

MeshDraft read_mesh(const Element& e, Problems& problems) {
  MeshDraft out;
  auto& mesh = out.mesh;
  mesh.interference = core::words::kInterferences.or_first(e.valued("interference"));
  mesh.hops = number_of<std::uint32_t>(e, "hops");
  out.states_hops = e.has("hops");
  mesh.limit = decimal<std::uint32_t>(e, "limit", problems);
  mesh.packet_bytes = number_of<std::uint32_t>(e, "packet-bytes");
  mesh.header_bytes = number_of<std::uint32_t>(e, "header-bytes");
  mesh.packet_time = decimal<Value>(e, "packet-time", problems);
  mesh.stale_after = decimal<Value>(e, "stale-after", problems);
  mesh.hold_up = decimal<Value>(e, "hold-up", problems);
  mesh.tolerance = decimal<std::uint32_t>(e, "tolerance", problems);
  mesh.origin = e.origin();
  for (const auto& child : e.children) {
    if (child.name == "PerHop") out.per_hop = per_hop(child, problems);
    if (child.name == "Node") out.nodes.push_back(node(child, problems));
    if (child.name == "Link") out.links.push_back(link(child, problems));
    if (child.name == "Domain") out.domains.push_back(domain(child));
    if (child.name == "Source") mesh.sources.push_back(source(child, problems));
  }
  return out;
}

}  // namespace mlcca::description
