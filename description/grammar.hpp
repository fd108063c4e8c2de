// SPDX-License-Identifier: BSD-2-Clause
// What system.xsd says of elements, as one table that is looked up while a document is read. It is
// made of the schema (make-grammar); here is its form.
#pragma once
#include <cstdint>
#include <span>
#include <string_view>

#include "description/values.hpp"

namespace mlcca::description {

struct ElementType;

/// An element that may stand at some place.
struct Child {
  std::string_view name;
  const ElementType* type = nullptr;
};

/// A place in the content of an element: one of `children`, so and so often.
struct Step {
  std::span<const Child> children;
  std::uint32_t least = 1;
  std::uint32_t most = 1;       ///< kUnlimited: no limit
  bool needs_previous = false;  ///< only after something at the previous step
  bool includes = false;        ///< xi:include may stand here
};

inline constexpr std::uint32_t kUnlimited = 0xffffffff;

/// An attribute of an element.
struct Key {
  std::string_view name;
  const ValueType* type = nullptr;
  bool required = false;
  std::string_view otherwise;  ///< its value where it is absent, if the schema states one
};

/// A type of element: a value, an empty element, or one with children.
struct ElementType {
  std::string_view name;  ///< of the type in the schema; of a plain value: the value's type
  const ValueType* value = nullptr;  ///< of its text; null: no text
  std::span<const Step> steps;       ///< in this order
  bool any_order = false;            ///< each step has one child, and they come in any order
  std::span<const Key> keys;
};

/// The root.
const Child& system_root();

/// What may be a part of System, and the root of a file that is included.
std::span<const Child> system_parts();

/// Every type that has children or attributes.
std::span<const ElementType* const> element_types();

}  // namespace mlcca::description
