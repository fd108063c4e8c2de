// SPDX-License-Identifier: BSD-2-Clause
#include "description/decimals.hpp"

#include <fmt/format.h>

#include <optional>

#include "base/decimal.hpp"
#include "description/values.hpp"

namespace mlcca::description {
namespace {

/// The integer of a decimal in that scale; nullopt if the text is empty or out of range.
std::optional<Value> whole(std::string_view text, const Scale& scale) {
  if (text.empty()) return std::nullopt;
  const auto number = Decimal::read(text);
  const auto value =
      number ? number->scaled(scale.digits, scale.rounding == Rounding::up) : std::nullopt;
  return value && *value >= scale.least && *value <= scale.most ? value : std::nullopt;
}

}  // namespace

Value decimal_of(const Element& e, std::string_view attribute, Problems& problems) {
  const auto* const key = e.known(attribute);
  if (key == nullptr) return 0;
  const auto& scale = key->type->scale;
  if (const auto text = e.attribute(attribute); !text.empty()) {
    if (const auto value = whole(text, scale)) return *value;
    problems.add(e.origin(), e.name,
                 fmt::format("attribute {}: {} is not right: {}", attribute, text, scale.range),
                 core::FindingId::not_in_schema);
  }
  return whole(key->otherwise, scale).value_or(0);
}

}  // namespace mlcca::description
