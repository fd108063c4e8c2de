// SPDX-License-Identifier: BSD-2-Clause
// A function for each message, its fields in the order of control.proto.
#include "tools/json.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string_view>
#include <variant>
#include <vector>

#include "core/model/text.hpp"
#include "mlcca/attribute.hpp"
#include "tools/render.hpp"
#include "tools/values.hpp"

namespace mlcca::tools {
namespace {

using Json = nlohmann::ordered_json;

Json quantity(std::uint64_t value) { return value == kUnbounded ? Json("unbounded") : Json(value); }

template <class T, class ToJson>
Json array(const std::vector<T>& elements, ToJson to_json) {
  auto result = Json::array();
  for (const auto& element : elements) result.push_back(to_json(element));
  return result;
}

/// Of a number whose 0 says that there is none.
Json unless_zero(std::uint64_t value) { return value == 0 ? Json() : quantity(value); }

Json subject(std::uint64_t value) {
  return value == 0 ? Json() : Json(core::format_subject(value));
}

const char* name_of(control::ErrorKind kind) {
  switch (kind) {
    case control::ErrorKind::invalid:
      return "invalid";
    case control::ErrorKind::forbidden:
      return "forbidden";
    case control::ErrorKind::unreadable:
      return "unreadable";
    case control::ErrorKind::world:
      return "world";
    case control::ErrorKind::unspecified:
      break;
  }
  return "unspecified";
}

const char* name_of(control::Outcome outcome) {
  switch (outcome) {
    case control::Outcome::fit:
      return "fit";
    case control::Outcome::run_time:
      return "run-time";
    case control::Outcome::unfit:
      break;
  }
  return "unfit";
}

Json attribute(const control::Attribute& a) {
  return {{"name", a.name}, {"value", quantity(a.value)}, {"unit", a.unit}, {"dynamic", a.dynamic}};
}

Json traffic(const control::Traffic& t) {
  auto reasons = Json::object();
  for (const auto& count : t.reasons) reasons[count.reason] = count.frames;
  auto would_drop = Json::object();
  for (const auto& count : t.would_drop_reasons) would_drop[count.reason] = count.frames;
  return {{"passed", t.passed}, {"dropped", t.dropped},       {"unknown", t.unknown},
          {"reasons", reasons}, {"would_drop", t.would_drop}, {"would_drop_reasons", would_drop}};
}

Json unknown(const control::Unknown& u) {
  Json out = {{"length", u.length}, {"egress", u.egress}, {"frames", u.frames}};
  if (u.subject != 0) {
    out["subject"] = core::format_subject(u.subject);
    out["address"] = u.address;
    out["mac"] = u.mac;
    return out;
  }
  out["can_id"] = u.can_id;
  out["identifier"] = print_can_id(u.can_id);
  out["fd"] = u.fd;
  out["xl"] = u.xl;
  return out;
}

const char* name_of(control::HealthState state) {
  switch (state) {
    case control::HealthState::healthy:
      return "healthy";
    case control::HealthState::degraded:
      return "degraded";
    case control::HealthState::closed:
      return "closed";
    case control::HealthState::unknown:
      break;
  }
  return "unknown";
}

Json actor(const std::optional<control::Actor>& a) {
  if (!a) return {};
  return {{"uid", a->uid}, {"user", a->user}, {"pid", a->pid}};
}

Json health(const control::Health& h) {
  return {{"state", name_of(h.state)}, {"reasons", h.reasons}, {"left_out", h.left_out}};
}

Json interface(const control::Interface& i) {
  return {{"name", i.name},
          {"ifindex", i.ifindex},
          {"network", i.network},
          {"identity", i.identity},
          {"profile", i.profile},
          {"managed", i.managed},
          {"up", i.up},
          {"can_state", i.can_state},
          {"bitrate", i.bitrate == 0 ? Json() : Json(i.bitrate)},
          {"gated", i.gated},
          {"drops_early", i.drops_early},
          {"slots", i.slots},
          {"ingress", traffic(i.ingress)},
          {"egress", traffic(i.egress)},
          {"unknown", array(i.unknown, unknown)},
          {"problem", i.problem},
          {"hook", i.hook},
          {"drift", i.drift},
          {"repaired", i.repaired},
          {"bypassed", i.bypassed}};
}

Json gate_slot(const control::GateSlot& s) {
  return {{"name", s.name},
          {"egress", s.egress},
          {"passes", s.passes},
          {"id", s.id},
          {"mask", s.mask},
          {"identifier", print_can_id(s.id)},
          {"formats", s.formats},
          {"max_length", s.max_length},
          {"source", s.source},
          {"per_frame_ns", s.per_frame_ns},
          {"per_byte", s.per_byte},
          {"tolerance_ns", s.tolerance_ns},
          {"excess_passes", s.excess_passes},
          {"passed", s.passed},
          {"dropped", s.dropped},
          {"would_drop", s.would_drop},
          {"excess", s.excess},
          {"bytes", s.bytes},
          {"last_reason", s.last_reason}};
}

/// An Ethernet gate goes by subject.
Json ethernet_slot(const control::GateSlot& s) {
  auto out = gate_slot(s);
  for (const char* of_can : {"id", "mask", "identifier"}) out.erase(of_can);
  return out;
}

Json gate(const control::Gate& g) {
  const auto slot = g.masked_room != 0 ? gate_slot : ethernet_slot;
  return {{"interface", g.interface},
          {"network", g.network},
          {"profile", g.profile},
          {"attached", g.attached},
          {"problem", g.problem},
          {"slots", g.slots},
          {"room", g.room},
          {"masked", g.masked},
          {"masked_room", g.masked_room},
          {"control", array(g.control, slot)},
          {"channels", array(g.channels, slot)}};
}

Json network(const control::Network& n) {
  return {{"name", n.name},
          {"kind", n.kind},
          {"profile", n.profile},
          {"provision", array(n.provision, attribute)},
          {"capacity", n.capacity_known ? quantity(n.capacity) : Json()},
          {"reserved", n.reserved},
          {"available", n.available},
          {"problem", n.problem},
          {"gateways", n.gateways}};
}

Json row(const control::Row& r) {
  return {{"where", r.where},
          {"attribute", r.attribute},
          {"unit", r.unit},
          {"required", quantity(r.required)},
          {"provided", r.provided_known ? quantity(r.provided) : Json()},
          {"dynamic", r.dynamic},
          {"outcome", name_of(r.outcome)},
          {"margin", r.margin}};
}

Json medium_use(const control::MediumUse& m) {
  const bool mesh = m.paper_rate != 0;
  return {{"network", m.network},
          {"response_ns", unless_zero(m.response_ns)},
          {"guaranteed_ns", unless_zero(m.guaranteed_ns)},
          {"paper_rate", unless_zero(m.paper_rate)},
          {"available", mesh ? quantity(m.available) : Json()},
          {"limiting_domain", m.limiting_domain},
          {"nodes", m.nodes}};
}

Json watch(const control::Watch& w) {
  return {{"period_ns", w.period_ns},
          {"silence_ns", unless_zero(w.silence_ns)},
          {"missing_now", w.missing_now},
          {"events", w.events},
          {"missing", w.missing},
          {"since_last_ns", w.since_last_ns},
          {"last_gap_ns", unless_zero(w.last_gap_ns)},
          {"shortest_gap_ns", unless_zero(w.shortest_gap_ns)},
          {"longest_gap_ns", unless_zero(w.longest_gap_ns)},
          {"jitter_ns", w.jitter_ns},
          {"rate_mhz", unless_zero(w.rate_mhz)},
          {"gaps", w.gaps}};
}

Json channel(const control::Channel& c) {
  return {{"subject", core::format_subject(c.subject)},
          {"name", c.name},
          {"description", c.description},
          {"publisher", c.publisher},
          {"from", c.from},
          {"to", c.to},
          {"subscribers", c.subscribers},
          {"granted", c.granted},
          {"reason", c.reason},
          {"route", c.route},
          {"rows", array(c.rows, row)},
          {"admission", c.admission},
          {"passed", c.passed},
          {"dropped", c.dropped},
          {"would_drop", c.would_drop},
          {"excess", c.excess},
          {"reaction", c.reaction},
          {"set", c.set},
          {"sets", c.sets},
          {"importance", c.importance},
          {"media", array(c.media, medium_use)},
          {"watch", c.watch ? watch(*c.watch) : Json()},
          {"troubles", c.troubles},
          {"subscribers_left_out", c.subscribers_left_out},
          {"rows_left_out", c.rows_left_out},
          {"withdrawn", c.withdrawn}};
}

Json route(const control::RouteReport& r) {
  return {{"from", r.from},       {"to", r.to},           {"places", r.places},
          {"granted", r.granted}, {"refused", r.refused}, {"media", array(r.media, medium_use)},
          {"problem", r.problem}};
}

Json mesh_link(const control::MeshLink& l) {
  return {{"network", l.network},
          {"from", l.from},
          {"to", l.to},
          {"rate", unless_zero(l.rate)},
          {"believed_rate", l.believed_rate},
          {"kind", l.kind},
          {"loss", l.loss_known ? Json(l.loss) : Json()},
          {"busy", l.busy_known ? Json(l.busy) : Json()},
          {"age_ns", quantity(l.age_ns)},
          {"stale", l.stale},
          {"lack", l.lack},
          {"source", l.source}};
}

Json can_rule(const control::CanRule& r) {
  return {{"from", r.from}, {"to", r.to},           {"id", r.id},           {"mask", r.mask},
          {"fd", r.fd},     {"ours", r.ours},       {"channel", r.channel}, {"change", r.change},
          {"hops", r.hops}, {"handled", r.handled}, {"dropped", r.dropped}, {"deleted", r.deleted}};
}

Json reservation(const control::Reservation& r) {
  return {{"channel", r.channel},
          {"publisher", r.publisher},
          {"amount", r.amount},
          {"admission", r.admission},
          {"set", r.set},
          {"importance", r.importance},
          {"lease_ns", unless_zero(r.lease_ns)}};
}

Json resource(const control::Resource& r) {
  return {{"name", r.name},
          {"kind", r.kind},
          {"unit", r.unit},
          {"capacity", r.capacity_known ? quantity(r.capacity) : Json()},
          {"reserved", r.reserved},
          {"background", r.background},
          {"reservations", array(r.reservations, reservation)}};
}

Json outlook(const control::Outlook& o) {
  return {{"channel", o.channel},
          {"publisher", o.publisher},
          {"to", o.to},
          {"granted_now", o.granted_now},
          {"granted_then", o.granted_then},
          {"set_now", o.set_now},
          {"set_then", o.set_then},
          {"reason", o.reason}};
}

Json history_entry(const control::HistoryEntry& h) {
  return {{"unix_ns", h.unix_ns}, {"kind", h.kind},       {"subject", subject(h.subject)},
          {"channel", h.channel}, {"from", h.from},       {"to", h.to},
          {"network", h.network}, {"message", h.message}, {"by", actor(h.by)}};
}

/// One function for each alternative of Reply::body.
struct Body {
  Json operator()(const control::Error& e) const {
    return {{"error", {{"kind", name_of(e.kind)}, {"message", e.message}, {"details", e.details}}}};
  }
  Json operator()(const control::Status& s) const {
    return {{"version", s.version},
            {"gateway", s.gateway},
            {"system", s.system},
            {"description_file", s.description_file},
            {"mode", s.mode},
            {"open", s.open},
            {"grace_ns", quantity(s.grace_ns)},
            {"lapses", s.lapses},
            {"channels_granted", s.channels_granted},
            {"channels_refused", s.channels_refused},
            {"started_unix_s", s.started_unix_s},
            {"loaded_unix_s", s.loaded_unix_s},
            {"last_error", s.last_error},
            {"interfaces", array(s.interfaces, interface)},
            {"problem", s.problem},
            {"health", health(s.health)}};
  }
  Json operator()(const control::Networks& n) const {
    return {{"networks", array(n.networks, network)}};
  }
  Json operator()(const control::Channels& c) const {
    return {{"channels", array(c.channels, channel)}, {"left_out", c.left_out}};
  }
  Json operator()(const control::Done& d) const { return {{"message", d.message}}; }
  Json operator()(const control::Event& e) const {
    return {{"unix_ns", e.unix_ns},          {"kind", e.kind},
            {"subject", subject(e.subject)}, {"channel", e.channel},
            {"network", e.network},          {"message", e.message},
            {"admissions", e.admissions},    {"silent_ns", unless_zero(e.silent_ns)},
            {"missing", e.missing},          {"by", actor(e.by)}};
  }
  Json operator()(const control::Routes& r) const {
    return {{"routes", array(r.routes, route)},
            {"links", array(r.links, mesh_link)},
            {"problems", r.problems},
            {"can_rules", array(r.can_rules, can_rule)}};
  }
  Json operator()(const control::Gates& g) const { return {{"gates", array(g.gates, gate)}}; }
  Json operator()(const control::Reservations& r) const {
    return {{"resources", array(r.resources, resource)}};
  }
  Json operator()(const control::WhatIf& w) const {
    return {{"outlooks", array(w.outlooks, outlook)}, {"unchanged", w.unchanged}};
  }
  Json operator()(const control::History& h) const {
    return {{"entries", array(h.entries, history_entry)}};
  }
};

/// JSON allows DEL and the control characters of C1 as they are; a terminal obeys them. They stand
/// in strings only.
std::string without_controls(std::string_view json) {
  std::string out;
  out.reserve(json.size());
  const auto octet = [&](std::size_t i) { return static_cast<unsigned char>(json[i]); };
  for (std::size_t i = 0; i < json.size(); ++i) {
    const bool c1 = octet(i) == 0xc2 && i + 1 < json.size() && octet(i + 1) < 0xa0;
    if (c1) ++i;
    if (c1 || octet(i) == 0x7f)
      out += fmt::format("\\u{:04x}", octet(i));
    else
      out += json[i];
  }
  return out;
}

std::string on_one_line(const Json& json) {
  return without_controls(json.dump(-1, ' ', false, Json::error_handler_t::replace)) + '\n';
}

}  // namespace

std::string to_json(const control::Reply& reply) {
  return on_one_line(std::visit(Body{}, reply.body));
}

std::string to_json(const control::Health& of_status) {
  return on_one_line({{"health", health(of_status)}});
}

std::string to_json(const control::Gates& gates,
                    const std::vector<control::Interface>& interfaces) {
  return on_one_line({{"gates", array(gates.gates, [&](const control::Gate& g) {
                         Json out = gate(g);
                         if (const auto* const i = interface_of(g, interfaces))
                           out.update({{"hook", i->hook},
                                       {"drops_early", i->drops_early},
                                       {"ingress", traffic(i->ingress)},
                                       {"egress", traffic(i->egress)}});
                         return out;
                       })}});
}

}  // namespace mlcca::tools
