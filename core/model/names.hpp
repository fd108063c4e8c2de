// SPDX-License-Identifier: BSD-2-Clause
// Channels and places by what people and programs call them.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <unordered_map>

#include "core/model/system.hpp"

namespace mlcca::core {

/// 64-bit subject of "0x…" with up to 16 hex digits; nothing otherwise.
[[nodiscard]] std::optional<Subject> parse_subject(const std::string& text);

/// An index of the names in a system. Channels can come and go; places stay.
class NameIndex {
 public:
  explicit NameIndex(const System& system);

  /// Adds a channel of that index, or gives its name and subject to it.
  void add(const EventChannel& channel, std::size_t index);
  void remove(const EventChannel& channel);

  [[nodiscard]] bool has_channel(const std::string& name) const {
    return channel_of_name_.contains(name);
  }
  /// The index of a channel, by its name or its subject as parse_subject() reads it.
  [[nodiscard]] std::optional<std::size_t> find_channel(const std::string& name_or_subject) const;
  [[nodiscard]] std::optional<std::size_t> channel_of(Subject subject) const;
  [[nodiscard]] std::optional<Place> find_place(const std::string& name) const;

 private:
  std::unordered_map<std::string, std::size_t> channel_of_name_;
  std::unordered_map<Subject, std::size_t> channel_of_subject_;
  std::unordered_map<std::string, Place> place_of_name_;
};

}  // namespace mlcca::core
