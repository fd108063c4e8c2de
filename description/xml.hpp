// SPDX-License-Identifier: BSD-2-Clause
// A document, validated while it is parsed and handed over part by part, so that memory is bounded
// by the largest part and not by the file. All of libxml2 is behind this.
#pragma once
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "description/problems.hpp"

namespace mlcca::description {

inline constexpr std::size_t kMaxFileBytes = std::size_t{16} << 20U;
inline constexpr std::size_t kMaxItems = std::size_t{1} << 20U;  ///< elements and attributes
inline constexpr std::size_t kMaxDepth = 256;                    ///< of elements in each other

/// A valid element. Texts have their white space collapsed, as every type of the schema wants it.
struct Element {
  std::string name;
  int line = 0;                                                 ///< where its start tag ends
  std::vector<std::pair<std::string, std::string>> attributes;  ///< those without a namespace
  std::string text;
  std::vector<Element> children;

  /// The attribute's value, or an empty text where it is absent.
  [[nodiscard]] std::string_view attribute(std::string_view key) const;
  /// The first child of that name, or null.
  [[nodiscard]] const Element* child(std::string_view key) const;
};

/// Parses `xml` against the schema. `root` receives the root without children, then `part` each of
/// its children that is valid, in order. Refuses a DTD, an encoding other than UTF-8, and what
/// exceeds the limits above. Opens no file and no connection. True if nothing was wrong.
bool parse(std::string_view xml, Problems& problems,
           const std::function<void(const Element&)>& root,
           const std::function<void(const Element&)>& part);

}  // namespace mlcca::description
