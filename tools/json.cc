// SPDX-License-Identifier: BSD-2-Clause
// A template converts all fields of control.proto to JSON; overloads convert the few messages that
// have another form.
#include "tools/json.hpp"

#include <fmt/format.h>

#include <concepts>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "control/fields.hpp"
#include "control/local_address.hpp"
#include "core/model/text.hpp"
#include "mlcca/attribute.hpp"
#include "tools/audit.hpp"
#include "tools/render.hpp"
#include "tools/values.hpp"

namespace mlcca::tools {
namespace {

using Json = nlohmann::ordered_json;
using control::Field;
using control::Message;

template <class T>
Json json_of(const T& value);

/// Counted reasons as an object: {"no-slot": 3}.
Json of(const std::vector<control::ReasonCount>& counts) {
  auto out = Json::object();
  for (const auto& count : counts) out[count.reason] = count.frames;
  return out;
}

/// An unknown frame, with the fields that its kind of gate knows: a subject and its sender, or an
/// identifier.
Json of(const control::Unknown& u) {
  Json out = {{"length", u.length}, {"egress", u.egress}, {"frames", u.frames}};
  if (u.subject != 0 || !u.address.empty() || !u.mac.empty()) {
    out["subject"] = core::format_subject(u.subject);
    out["address"] = u.address;
    out["mac"] = u.mac;
    out["channel"] = u.channel.empty() ? Json() : Json(u.channel);
    return out;
  }
  out["can_id"] = u.can_id;
  out["identifier"] = print_can_id(u.can_id);
  out["fd"] = u.fd;
  out["xl"] = u.xl;
  return out;
}

template <class T>
Json json_of_field(const Field& field, const T& value) {
  if constexpr (std::integral<T>)
    if (field.zero_is_none && value == 0) return {};
  if constexpr (std::same_as<T, std::uint64_t>)
    if (field.as_subject) return core::format_subject(value);
  return json_of(value);
}

/// All fields of a message. A field NAME with a companion NAME_known that is false becomes null.
template <Message M>
Json fields_of(const M& message) {
  auto out = Json::object();
  std::string unknown;
  for_each_field(message, [&](const Field& field, const auto& value) {
    using T = std::remove_cvref_t<decltype(value)>;
    const std::string name = field.name;
    if constexpr (std::same_as<T, bool>) {
      constexpr std::string_view suffix = "_known";
      if (name.ends_with(suffix)) {
        if (!value) unknown = name.substr(0, name.size() - suffix.size());
        return;
      }
    }
    Json& to = out[name];
    if (name == unknown) return;
    to = json_of_field(field, value);
  });
  return out;
}

/// A slot, with its identifier also in the form of candump.
Json of(const control::GateSlot& s) {
  auto out = fields_of(s);
  out["identifier"] = print_can_id(s.id);
  return out;
}

/// Slots of an Ethernet gate have no identifier, because they are found by subject.
Json of(const control::Gate& g) {
  auto out = fields_of(g);
  if (g.masked_slots_limit != 0) return out;
  for (const char* list : {"control", "channels"})
    for (auto& slot : out[list])
      for (const char* of_can : {"id", "mask", "identifier"}) slot.erase(of_can);
  return out;
}

/// The findings, each with its identifier in the form of candump and the elements that a
/// description would need.
Json of(const control::Audit& a) {
  auto out = fields_of(a);
  const std::vector<std::string> additions = additions_of(a);
  for (std::size_t i = 0; i < a.findings.size(); ++i) {
    const control::Finding& f = a.findings[i];
    Json& one = out["findings"][i];
    const bool is_subject = f.channel.empty() && !f.others && !is_can_frame(f);
    one["identifier"] = is_can_frame(f) ? Json(name_of(f)) : Json();
    if (is_subject && !name_of(f).empty()) one["subject"] = name_of(f);
    if (const std::string sender = sender_of(f); !sender.empty()) one["sender"] = sender;
    const std::string advised = advice(f);
    one["advice"] = advised.empty() ? Json() : Json(advised);
    one["add"] = additions[i].empty() ? Json() : Json(additions[i]);
  }
  return out;
}

/// Of a receiver on the gateway only the name of its socket is printed, not its key: output is kept
/// in logs.
Json of(const control::Endpoint& e) {
  auto out = fields_of(e);
  out["local"] = e.local.substr(0, control::LocalAddress::kNameDigits);
  return out;
}

/// Rates are meaningful only for a mesh.
Json of(const control::MediumUse& m) {
  auto out = fields_of(m);
  if (m.path_rate == 0) out["available"] = nullptr;
  return out;
}

/// If no gate counts the frames, the number that passed is not known.
Json of(const control::Channel& c) {
  auto out = fields_of(c);
  if (c.crosses_no_gate) out["passed"] = nullptr;
  return out;
}

template <class T>
concept HasRuleOfItsOwn = requires(const T& value) { of(value); };
template <class T>
concept Optional = requires(const T& value) { value.has_value(); };
template <class T>
concept List = requires { typename T::value_type; } && !std::same_as<T, std::string>;

/// Numbers in lists are ids and counts, so 2^64-1 does not mean "unbounded" there.
template <class T>
Json list(const std::vector<T>& elements) {
  auto out = Json::array();
  for (const T& element : elements)
    if constexpr (std::integral<T>)
      out.push_back(element);
    else
      out.push_back(json_of(element));
  return out;
}

template <class T>
Json json_of(const T& value) {
  if constexpr (HasRuleOfItsOwn<T>)
    return of(value);
  else if constexpr (Message<T>)
    return fields_of(value);
  else if constexpr (std::is_enum_v<T>)
    return name_of(value);
  else if constexpr (Optional<T>)
    return value ? json_of(*value) : Json();
  else if constexpr (List<T>)
    return list(value);
  else if constexpr (std::same_as<T, std::uint64_t>)
    return value == kUnbounded ? Json("unbounded") : Json(value);
  else
    return value;
}

/// Replaces DEL and the control characters of C1, which JSON allows unescaped but a terminal obeys.
/// They occur only in strings of the JSON.
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
  if (const auto* error = std::get_if<control::Error>(&reply.body))
    return on_one_line({{"error", json_of(*error)}});
  return on_one_line(std::visit([](const auto& body) { return json_of(body); }, reply.body));
}

std::string to_json(const control::Health& of_status) {
  return on_one_line({{"health", json_of(of_status)}});
}

std::string to_json(const control::Gates& gates,
                    const std::vector<control::Interface>& interfaces) {
  auto out = Json::array();
  for (const control::Gate& gate : gates.gates) {
    Json& one = out.emplace_back(json_of(gate));
    if (const auto* const i = interface_of(gate, interfaces))
      one.update({{"hook", i->hook},
                  {"drops_early", i->drops_early},
                  {"ingress", json_of(i->ingress)},
                  {"egress", json_of(i->egress)}});
  }
  return on_one_line({{"gates", out}});
}

}  // namespace mlcca::tools
