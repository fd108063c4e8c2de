// SPDX-License-Identifier: BSD-2-Clause
// Checks the children of an element against its type, and explains those that are not allowed.
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

/// The position in an element's content after the children read so far.
struct Content {
  std::size_t step = 0;     ///< index of the current step of the type
  std::uint32_t count = 0;  ///< children at that step so far
  std::uint32_t seen = 0;   ///< bit i: step i has a child; for types whose steps may come in any
                            ///< order
};

/// Returns the child with that name if it is allowed here, and moves `content` behind it; otherwise
/// null.
const Child* next_child(const ElementType& type, Content& content, std::string_view name);

/// Whether no required child is missing.
bool is_complete(const ElementType& type, const Content& content);

/// Whether the type is a list of independent parts: they may come in any number, and a wrong one
/// does not invalidate the others.
bool is_container(const ElementType& type);

/// The names of all such types.
std::vector<std::string_view> containers();

/// The text for a child that next_child() refuses. `parent`: name of the element; `before`: its
/// children so far.
std::string explain_child(const ElementType& type, const Content& content, std::string_view parent,
                          std::string_view name, std::span<const Element> before);

/// The text for an incomplete element: "is not complete: it needs ..."
std::string explain_incomplete(const ElementType& type, const Content& content);

/// The text for an attribute that `element` does not have.
std::string explain_key(const ElementType& type, std::string_view element, std::string_view key);

}  // namespace mlcca::description
