// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/generate/attributes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string_view>
#include <vector>

#include "mlcca/der_encode.hpp"

namespace mlcca::tools::design {
namespace {

struct Literal {
  std::string_view base;  ///< AttributeInfo::unit
  std::string_view suffix;
  Value scale;
  std::string_view type;
};
/// Units of literals, the largest one first.
constexpr auto kLiterals =
    std::to_array<Literal>({{"ns", "_s", 1'000'000'000, "Nanoseconds"},
                            {"ns", "_ms", 1'000'000, "Nanoseconds"},
                            {"ns", "_us", 1'000, "Nanoseconds"},
                            {"ns", "_ns", 1, "Nanoseconds"},
                            {"bytes/s", "_kB_per_s", 1'000, "BytesPerSecond"},
                            {"bytes/s", "_bytes_per_s", 1, "BytesPerSecond"},
                            {"1e-9", "_percent", 10'000'000, "PerBillion"},
                            {"1e-9", "_ppm", 1'000, "PerBillion"},
                            {"1e-9", "_ppb", 1, "PerBillion"},
                            {"bytes", "_bytes", 1, "Bytes"}});

std::string literal(Attribute attribute, Value value) {
  const std::string_view base = info(attribute).unit;
  const auto* found = std::ranges::find_if(kLiterals, [&](const Literal& l) {
    return l.base == base && (l.scale == 1 || (value != 0 && value % l.scale == 0));
  });
  if (found == kLiterals.end()) return number(value);  // events are a plain number
  // No literal can express it.
  if (value == kUnbounded)
    return fmt::format("static_cast<mlcca::{}>(mlcca::kUnbounded)", found->type);
  return fmt::format("{}{}", value / found->scale, found->suffix);
}

std::string with_mark(std::string type, bool dynamic) {
  return dynamic ? fmt::format("mlcca::Dynamic<{}>", type) : type;
}

}  // namespace

std::string number(Value value) {
  constexpr Value of_every_int = 32767;
  constexpr auto of_long_long = static_cast<Value>(std::numeric_limits<std::int64_t>::max());
  const char* suffix = value <= of_every_int ? "" : "LL";
  return fmt::format("{}{}", value, value <= of_long_long ? suffix : "ULL");
}

std::string attribute_list(const AttributeSet& set, const core::UserValues& values,
                           const UserTypes& user) {
  std::string out;
  const auto add = [&](const std::string& type) {
    out += (out.empty() ? "\n      " : ",\n      ") + type;
  };
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const auto a = attribute_at(i);
    if (set.has(a))
      add(with_mark(fmt::format("mlcca::{}<{}>", info(a).name, literal(a, set[a])),
                    set.is_dynamic(a)));
  }
  for (const auto& value : values)
    add(with_mark(fmt::format("{}<{}>", user.at(value.attribute), number(value.value)),
                  value.dynamic));
  return fmt::format("mlcca::AttributeList<{}>", out);
}

core::UserValues sorted_by_name(const core::System& system, core::UserValues values) {
  std::ranges::sort(values, {}, [&](const core::UserValue& v) -> const std::string& {
    return system.user_attributes[v.attribute].name;
  });
  return values;
}

Result<std::string> der_of(const core::System& system, der::Role role, core::Subject subject,
                           const AttributeSet& set, const core::UserValues& values) {
  std::vector<der::UserAttribute> user;
  user.reserve(values.size());
  for (const auto& value : sorted_by_name(system, values)) {
    const auto& name = system.user_attributes[value.attribute].name;
    user.emplace_back(name.data(), name.size(), value.value, value.dynamic);
  }
  const der::Channel channel(role, subject, set, user.data(), user.size());
  if (const auto error = der::encodable(channel); error != der::Error::none)
    return fail(fmt::format("no DER: {}", der::to_text(error)));
  std::string out(der::encoded_size(channel), '\0');
  der::encode(channel, reinterpret_cast<std::uint8_t*>(out.data()), out.size());
  return out;
}

}  // namespace mlcca::tools::design
