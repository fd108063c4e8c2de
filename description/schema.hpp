// SPDX-License-Identifier: BSD-2-Clause
// What the schema says, in the words of our problems. The tables repeat system.xsd for people; a
// test holds them together.
#pragma once
#include <span>
#include <string>
#include <string_view>

namespace mlcca::description {

/// What a value of one of the schema's types looks like.
struct TypeWords {
  std::string_view type;
  std::string_view pattern;  ///< as in the schema, or empty
  std::string_view words;
};

/// What an element may hold, for the elements that are no plain value.
struct ElementWords {
  std::string_view element;
  std::span<const std::string_view> children;
  std::span<const std::string_view> attributes;
};

std::span<const TypeWords> type_words();
std::span<const ElementWords> element_words();

/// The row of that element, or null.
const ElementWords* words_of(std::string_view element);

/// Turns a message of the validator ("Element 'Port', attribute 'managed': …") about `element`, a
/// child of `parent`, into ours: without the element, and with what would be right.
std::string explain_schema_message(std::string_view message, std::string_view element,
                                   std::string_view parent);

}  // namespace mlcca::description
