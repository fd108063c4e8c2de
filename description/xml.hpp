// SPDX-License-Identifier: BSD-2-Clause
// An element of a description, as it is handed over part by part, so that memory is bounded by the
// largest part and not by the files.
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

inline constexpr std::size_t kMaxBytes = std::size_t{256} << 20U;  ///< of all files together
inline constexpr std::size_t kMaxItems = std::size_t{1} << 24U;    ///< elements and attributes
inline constexpr std::size_t kMaxDepth = 256;                      ///< of elements in each other
inline constexpr std::size_t kMaxAttributes = 64;                  ///< of an element
inline constexpr std::size_t kMaxValue = std::size_t{64} << 10U;   ///< bytes of a value or text
inline constexpr std::size_t kMaxFiles = 1024;                     ///< opened, each time it is
inline constexpr std::size_t kMaxIncludes = 16;                    ///< of files in each other

/// An attribute without a namespace.
struct KeyValue {
  std::string_view key;
  std::string_view value;
};

/// A valid element. Texts have their white space collapsed, as every type of the schema wants it.
/// All of it is gone when the function that was given it returns.
struct Element {
  std::string_view name;
  int line = 0;            ///< where its start tag ends
  std::uint32_t file = 0;  ///< index into Problems::files()
  std::string_view text;
  std::span<const KeyValue> attributes;
  std::span<const Element> children;
  const ElementType* type = nullptr;

  [[nodiscard]] bool has(std::string_view key) const {
    return std::ranges::find(attributes, key, &KeyValue::key) != attributes.end();
  }
  /// The attribute's value, or an empty text where it is absent.
  [[nodiscard]] std::string_view attribute(std::string_view key) const {
    for (const auto& a : attributes)
      if (a.key == key) return a.value;
    return {};
  }
  /// What the schema says of the attribute; null: nothing.
  [[nodiscard]] const Key* known(std::string_view key) const {
    for (const auto& k : type->keys)
      if (k.name == key) return &k;
    return nullptr;
  }
  /// The attribute's value, stated or by default; an empty text without either.
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
  /// For problems about it, and for what is made of it.
  [[nodiscard]] core::Origin origin() const { return {.file = file, .line = line}; }
};

/// Who is told what a description holds.
struct Receiver {
  /// The root without children, once, before its parts.
  std::function<void(const Element&)> root;
  /// Each valid child of System, in order, included ones in their place.
  std::function<void(const Element&)> part;
};

/// Which elements a file may have as its root.
enum class Root : std::uint8_t { system, system_or_part };

/// Parses paths[0], what it includes, and then the further paths as parts of the same System, all
/// against the schema. Refuses a DTD, an encoding other than UTF-8, an inclusion of anything but a
/// local file, and what exceeds the limits above. True if nothing was wrong. paths[0] must be
/// the file that `problems` was made for. `digest`, where there is one, gets that of the contents
/// of all files, in the order in which they are opened; it says something if nothing was wrong.
/// `bundle` gets all of them (bundle.hpp), or nothing if they are too long for that.
bool parse_files(std::span<const std::string> paths, Root root, Problems& problems,
                 const Receiver& receiver, const Progress& progress,
                 Sha256::Digest* digest = nullptr, std::string* bundle = nullptr);

/// The same of what `bundle` has been given by parse_files(): all of it, and no other file.
bool parse_bundle(std::string_view bundle, Problems& problems, const Receiver& receiver,
                  Sha256::Digest& digest);

/// The same for one text. Files are included relative to the folder `base`, or refused if that is
/// empty.
bool parse_text(std::string_view xml, const std::string& base, Problems& problems,
                const Receiver& receiver);

}  // namespace mlcca::description
