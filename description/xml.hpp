// SPDX-License-Identifier: BSD-2-Clause
// The elements of a description. They are handed over part by part, so that memory is bounded by
// the largest part and not by the files.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/sha256.hpp"
#include "description/grammar.hpp"
#include "description/problems.hpp"

namespace mlcca::description {

inline constexpr std::size_t kMaxBytes = std::size_t{256} << 20U;  ///< all files together
inline constexpr std::size_t kMaxItems = std::size_t{1} << 24U;    ///< elements and attributes
inline constexpr std::size_t kMaxDepth = 256;                      ///< nested elements
inline constexpr std::size_t kMaxAttributes = 64;                  ///< of an element
inline constexpr std::size_t kMaxValue = std::size_t{64} << 10U;   ///< bytes of a value or text
inline constexpr std::size_t kMaxFiles = 1024;   ///< opened files; a file counts each time it is
                                                 ///< opened
inline constexpr std::size_t kMaxIncludes = 16;  ///< nested inclusions

/// An attribute without a namespace.
struct KeyValue {
  std::string_view key;
  std::string_view value;
};

/// A valid element. White space in its texts is collapsed, as all types of the schema require. It
/// is valid only until the function returns that it was passed to.
struct Element {
  std::string_view name;
  int line = 0;            ///< line in which its start tag begins
  std::uint32_t file = 0;  ///< index in Problems::files()
  std::string_view text;
  std::span<const KeyValue> attributes;
  std::span<const Element> children;
  const ElementType* type = nullptr;

  [[nodiscard]] bool has(std::string_view key) const {
    return std::ranges::find(attributes, key, &KeyValue::key) != attributes.end();
  }
  /// The value of the attribute; empty if it is absent.
  [[nodiscard]] std::string_view attribute(std::string_view key) const {
    for (const auto& a : attributes)
      if (a.key == key) return a.value;
    return {};
  }
  /// What the schema says about the attribute; null if it does not exist.
  [[nodiscard]] const Key* known(std::string_view key) const {
    for (const auto& k : type->keys)
      if (k.name == key) return &k;
    return nullptr;
  }
  /// The value of the attribute, or its default in the schema; empty without either.
  [[nodiscard]] std::string_view valued(std::string_view key) const {
    for (const auto& a : attributes)
      if (a.key == key) return a.value;
    const auto* const found = known(key);
    return found == nullptr ? std::string_view() : found->otherwise;
  }
  /// The first child of that name, or null.
  [[nodiscard]] const Element* child(std::string_view key) const {
    for (const auto& c : children)
      if (c.name == key) return &c;
    return nullptr;
  }
  /// The place of the element, for problems and for the parts of the System made of it.
  [[nodiscard]] core::Origin origin() const { return {.file = file, .line = line}; }
};

/// The functions that receive the elements of a description.
struct Receiver {
  /// Called once with the root, without children, before its parts.
  std::function<void(const Element&)> root;
  /// Called with each valid child of System in their order, included ones at their place.
  std::function<void(const Element&)> part;
};

/// The elements that a file may have as its root.
enum class Root : std::uint8_t { system, system_or_part };

/// Parses paths[0] with the files that it includes, and then the further paths as parts of the same
/// System, and checks them against the schema. It refuses a DTD, an encoding other than UTF-8,
/// inclusions of anything but local files, and what exceeds the limits above. Returns true if
/// nothing was wrong. paths[0] must be the file that `problems` was made for. `digest`, if not
/// null, gets the digest of the contents of all files in the order in which they are opened; it is
/// meaningful only if nothing was wrong. `bundle`, if not null, gets all files (bundle.hpp), or an
/// empty text if that would be too long.
bool parse_files(std::span<const std::string> paths, Root root, Problems& problems,
                 const Receiver& receiver, const Progress& progress,
                 Sha256::Digest* digest = nullptr, std::string* bundle = nullptr);

/// Parses a bundle in the same way, without opening any file.
bool parse_bundle(std::string_view bundle, Problems& problems, const Receiver& receiver,
                  Sha256::Digest& digest);

/// Parses one text in the same way. Files are included relative to the folder `base`; if that is
/// empty, they are refused.
bool parse_text(std::string_view xml, const std::string& base, Problems& problems,
                const Receiver& receiver);

}  // namespace mlcca::description
