// SPDX-License-Identifier: BSD-2-Clause
#include "core/model/names.hpp"

#include <string_view>

#include "base/number.hpp"

namespace mlcca::core {

NameIndex::NameIndex(const System& system) {
  for (std::size_t c = 0; c < system.channels.size(); ++c)
    if (!system.channels[c].name.empty()) {
      channel_of_name_.emplace(system.channels[c].name, c);
      channel_of_subject_.emplace(system.channels[c].subject, c);
    }
  for (std::size_t n = 0; n < system.networks.size(); ++n)
    place_of_name_.emplace(system.networks[n].name, Place{Place::Kind::network, n});
  for (std::size_t g = 0; g < system.gateways.size(); ++g)
    place_of_name_.emplace(system.gateways[g].name, Place{Place::Kind::gateway, g});
}

void NameIndex::add(const EventChannel& channel, std::size_t index) {
  channel_of_name_.insert_or_assign(channel.name, index);
  channel_of_subject_.insert_or_assign(channel.subject, index);
}

void NameIndex::remove(const EventChannel& channel) {
  channel_of_name_.erase(channel.name);
  channel_of_subject_.erase(channel.subject);
}

std::optional<std::size_t> NameIndex::find_channel(const std::string& name_or_subject) const {
  if (const auto subject = parse_subject(name_or_subject)) return channel_of(*subject);
  const auto it = channel_of_name_.find(name_or_subject);
  if (it == channel_of_name_.end()) return std::nullopt;
  return it->second;
}

std::optional<std::size_t> NameIndex::channel_of(Subject subject) const {
  const auto it = channel_of_subject_.find(subject);
  if (it == channel_of_subject_.end()) return std::nullopt;
  return it->second;
}

std::optional<Place> NameIndex::find_place(const std::string& name) const {
  const auto it = place_of_name_.find(name);
  if (it == place_of_name_.end()) return std::nullopt;
  return it->second;
}

std::optional<Subject> parse_subject(const std::string& text) {
  if (!text.starts_with("0x") && !text.starts_with("0X")) return std::nullopt;
  return number_in<Subject>(std::string_view(text).substr(2), kHexadecimalBase);
}

}  // namespace mlcca::core
