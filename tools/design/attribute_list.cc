// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/attribute_list.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "description/short_form.hpp"

namespace mlcca::tools::design {
namespace {

/// A unit of the attribute table: its dimension, and the elements that express it.
struct Shape {
  std::string_view table_unit;  ///< AttributeInfo::unit
  description::Dimension dimension;
  std::string_view unit;
};
constexpr int kNano = -9;
constexpr std::array<Shape, 5> kShapes = {
    {{"ns", {{1}, kNano}, "<Seconds>1</Seconds>"},
     {"bytes/s", {{-1, 1}, 0}, "<Seconds>-1</Seconds><Bytes>1</Bytes>"},
     {"1e-9", {{}, kNano}, ""},
     {"events", {{}, 0}, ""},
     {"bytes", {{0, 1}, 0}, "<Bytes>1</Bytes>"}}};

constexpr bool every_unit_has_a_shape() {
  return std::ranges::all_of(kAttributeTable, [](const AttributeInfo& row) {
    return std::ranges::find(kShapes, std::string_view(row.unit), &Shape::table_unit) !=
           kShapes.end();
  });
}
static_assert(every_unit_has_a_shape());

const Shape& shape_of(Attribute attribute) {
  return *std::ranges::find(kShapes, std::string_view(info(attribute).unit), &Shape::table_unit);
}

/// Converts 20000000 with magnitude -9 into 20 with magnitude -3, as people write it.
std::pair<Value, description::Dimension> in_thousands(Value value,
                                                      description::Dimension dimension) {
  constexpr Value thousand = 1000;
  const bool is_size = dimension.unit == description::Unit{0, 1};
  const int most = dimension.unit[0] == 1 ? 0 : 9;
  while (!is_size && value != 0 && value % thousand == 0 && dimension.magnitude < most) {
    value /= thousand;
    dimension.magnitude += 3;
  }
  return {value, dimension};
}

std::string one_element(Attribute attribute, Value value, bool dynamic) {
  const Shape& shape = shape_of(attribute);
  const auto [number, scaled] = in_thousands(value, shape.dimension);
  std::string dimension;
  if (!shape.unit.empty()) dimension += fmt::format("<SIUnit>{}</SIUnit>", shape.unit);
  if (scaled.magnitude != 0)
    dimension += fmt::format("<Magnitude>{}</Magnitude>", scaled.magnitude);
  if (!dimension.empty()) dimension = "<Dimension>" + dimension + "</Dimension>";
  return fmt::format("<Attribute{}><Name>{}</Name>{}<Value>{}</Value></Attribute>",
                     dynamic ? R"( dynamic="true")" : "", info(attribute).name, dimension, number);
}

}  // namespace

std::string attribute_list(std::string_view element, const AttributeSet& attributes,
                           std::string_view indent) {
  if (attributes.empty()) return {};
  const auto* const list = description::list_named(element);
  std::string in_tag;
  std::string elements;
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const Attribute a = attribute_at(i);
    if (!attributes.has(a)) continue;
    std::optional<std::string> text;
    if (list != nullptr && !attributes.is_dynamic(a)) {
      const auto [value, dimension] = in_thousands(attributes[a], shape_of(a).dimension);
      text = description::write_short(*list, a, {std::to_string(value), dimension});
    }
    if (text)
      in_tag += fmt::format(" {}=\"{}\"", description::short_name(a), *text);
    else
      elements +=
          fmt::format("{}  {}\n", indent, one_element(a, attributes[a], attributes.is_dynamic(a)));
  }
  if (elements.empty()) return fmt::format("{}<{}{}/>\n", indent, element, in_tag);
  return fmt::format("{0}<{1}{2}>\n{3}{0}</{1}>\n", indent, element, in_tag, elements);
}

}  // namespace mlcca::tools::design
