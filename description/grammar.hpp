// SPDX-License-Identifier: BSD-2-Clause
// The form of the grammar table: what system.xsd says about elements. make-grammar generates the
// table from the schema, and it is looked up while a document is read.
#pragma once
#include <cstdint>
#include <span>
#include <string_view>

#include "description/values.hpp"

namespace mlcca::description {

struct ElementType;

/// An element that is allowed at some place.
struct Child {
  std::string_view name;
  const ElementType* type = nullptr;
};

/// A step in the content of an element: one of `children`, `least` to `most` times.
struct Step {
  std::span<const Child> children;
  std::uint32_t least = 1;
  std::uint32_t most = 1;       ///< kUnlimited: without limit
  bool needs_previous = false;  ///< allowed only if the previous step has a child
  bool includes = false;        ///< xi:include is allowed here
};

inline constexpr std::uint32_t kUnlimited = 0xffffffff;

/// An attribute of an element.
struct Key {
  std::string_view name;
  const ValueType* type = nullptr;
  bool required = false;
  std::string_view otherwise;  ///< default value in the schema; empty without one
};

/// A type of element: a value, an empty element, or one with children.
struct ElementType {
  std::string_view name;  ///< name of the type in the schema; for a plain value, the name of the
                          ///< value's type
  const ValueType* value = nullptr;  ///< type of its text; null: it has no text
  std::span<const Step> steps;       ///< in the order of the content
  bool any_order = false;  ///< each step has at most one child, and they may come in any order
  std::span<const Key> keys;
};

/// The root element System.
const Child& system_root();

/// The elements that may be a part of System, or the root of an included file.
std::span<const Child> system_parts();

/// All types that have children or attributes.
std::span<const ElementType* const> element_types();

}  // namespace mlcca::description
