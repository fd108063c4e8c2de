// SPDX-License-Identifier: BSD-2-Clause
// Which children an element may still have, and what is said when another one comes.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "description/grammar.hpp"
#include "description/xml.hpp"

namespace mlcca::description {

/// How far the children of an element have come.
struct Content {
  std::size_t step = 0;     ///< of the type's steps
  std::uint32_t count = 0;  ///< children at that step
  std::uint32_t seen = 0;   ///< bit i: step i has a child; for steps in any order
};

/// The child of that name at this place, which `content` then stands behind; or null.
const Child* next_child(const ElementType& type, Content& content, std::string_view name);

/// Nothing is missing.
bool is_complete(const ElementType& type, const Content& content);

/// Its parts come in any number, and one that is wrong says nothing about the others.
bool is_container(const ElementType& type);

/// The names of all of which that is true.
std::vector<std::string_view> containers();

/// What is said of a child that next_child refuses; `parent` is the name of the element, `before`
/// are the children that it has so far.
std::string explain_child(const ElementType& type, const Content& content, std::string_view parent,
                          std::string_view name, std::span<const Element> before);

/// "is not complete: it needs ..."
std::string explain_incomplete(const ElementType& type, const Content& content);

/// What is said of an attribute that `element` does not have.
std::string explain_key(const ElementType& type, std::string_view element, std::string_view key);

}  // namespace mlcca::description
