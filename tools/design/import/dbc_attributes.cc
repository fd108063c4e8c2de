// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/import/dbc_attributes.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "base/number.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::size_t kMostDefinitions = 4'096;

struct Meaning {
  DbcObject object;
  std::string_view name;  ///< in small letters
  DbcRole role;
};

/// The attributes with a meaning. If a file states several of one role, the first one counts.
constexpr auto kMeanings = std::to_array<Meaning>({
    {DbcObject::message, "genmsgcycletime", DbcRole::cycle},
    {DbcObject::message, "cycletime", DbcRole::cycle},
    {DbcObject::message, "msgcycletime", DbcRole::cycle},
    {DbcObject::message, "messagecycletime", DbcRole::cycle},
    {DbcObject::message, "cycle_time", DbcRole::cycle},
    {DbcObject::message, "genmsgcycletimefast", DbcRole::fast},
    {DbcObject::message, "genmsgcycletimeactive", DbcRole::fast},
    {DbcObject::message, "cycletimefast", DbcRole::fast},
    {DbcObject::message, "cycletimeactive", DbcRole::fast},
    {DbcObject::message, "msgcycletimefast", DbcRole::fast},
    {DbcObject::message, "genmsgdelaytime", DbcRole::delay},
    {DbcObject::message, "msgdelaytime", DbcRole::delay},
    {DbcObject::message, "delaytime", DbcRole::delay},
    {DbcObject::message, "genmsgminimumdelaytime", DbcRole::delay},
    {DbcObject::message, "genmsgsendtype", DbcRole::send_type},
    {DbcObject::message, "msgsendtype", DbcRole::send_type},
    {DbcObject::message, "sendtype", DbcRole::send_type},
    {DbcObject::message, "vframeformat", DbcRole::format},
    {DbcObject::message, "systemmessagelongsymbol", DbcRole::long_name},
    {DbcObject::signal, "gensigcycletime", DbcRole::signal_cycle},
    {DbcObject::signal, "gensigcycletimeactive", DbcRole::signal_fast},
    {DbcObject::signal, "gensigcycletimefast", DbcRole::signal_fast},
    {DbcObject::signal, "gensigsendtype", DbcRole::signal_send_type},
    {DbcObject::signal, "sigsendtype", DbcRole::signal_send_type},
    {DbcObject::signal, "sigcycletime", DbcRole::signal_cycle},
    {DbcObject::node, "nmstationaddress", DbcRole::address},
    {DbcObject::node, "systemnodelongsymbol", DbcRole::long_name},
    {DbcObject::network, "bustype", DbcRole::bus_type},
    {DbcObject::network, "baudrate", DbcRole::baudrate},
    {DbcObject::network, "baudratecanfd", DbcRole::data_baudrate},
    {DbcObject::network, "protocoltype", DbcRole::protocol},
});

std::string small_letters(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

}  // namespace

DbcRole role_of(DbcObject object, std::string_view name) {
  const auto wanted = small_letters(name);
  const auto* const found = std::ranges::find_if(
      kMeanings, [&](const Meaning& m) { return m.object == object && m.name == wanted; });
  return found == kMeanings.end() ? DbcRole::none : found->role;
}

DbcValue* place_of(DbcMessage& message, DbcRole role) {
  switch (role) {
    case DbcRole::cycle:
      return &message.cycle;
    case DbcRole::fast:
      return &message.fast;
    case DbcRole::delay:
      return &message.delay;
    case DbcRole::send_type:
      return &message.send_type;
    case DbcRole::format:
      return &message.format;
    case DbcRole::long_name:
      return &message.long_name;
    default:
      return nullptr;
  }
}

DbcSignalValues* values_of_signals(DbcMessage& message, DbcRole role) {
  switch (role) {
    case DbcRole::signal_cycle:
      return &message.signal_cycles;
    case DbcRole::signal_fast:
      return &message.signal_fast;
    case DbcRole::signal_send_type:
      return &message.signal_send_types;
    default:
      return nullptr;
  }
}

DbcValue* place_of(DbcNode& node, DbcRole role) {
  if (role == DbcRole::address) return &node.address;
  return role == DbcRole::long_name ? &node.long_name : nullptr;
}

DbcValue* place_of(DbcFile& file, DbcRole role) {
  switch (role) {
    case DbcRole::bus_type:
      return &file.bus_type;
    case DbcRole::baudrate:
      return &file.baudrate;
    case DbcRole::data_baudrate:
      return &file.data_baudrate;
    case DbcRole::protocol:
      return &file.protocol;
    default:
      return nullptr;
  }
}

bool DbcDefinitions::define(DbcObject object, std::string_view name,
                            std::vector<std::string> words) {
  if (definitions_.size() >= kMostDefinitions) return false;
  definitions_[{object, std::string(name)}].words = std::move(words);
  return true;
}

bool DbcDefinitions::set_default(std::string_view name, const std::string& value) {
  // The definition of a default does not name the kind of object, but names are unique in practice.
  bool known = false;
  for (auto& [key, definition] : definitions_) {
    if (key.second != name) continue;
    definition.otherwise = value;
    known = true;
  }
  return known;
}

void DbcDefinitions::complete(DbcFile& file) const {
  complete(file, DbcObject::network);
  complete_all(file.nodes, DbcObject::node);
  complete_all(file.messages, DbcObject::message);
  complete_signals(file);
}

std::vector<DbcDefinitions::Meant> DbcDefinitions::meant(DbcObject object) const {
  std::vector<Meant> out;
  for (const auto& [key, definition] : definitions_)
    if (key.first == object)
      if (const auto role = role_of(object, key.second); role != DbcRole::none)
        out.push_back({role, &definition});
  return out;
}

void DbcDefinitions::complete(DbcFile& file, DbcObject object) const {
  for (const auto& [role, definition] : meant(object)) complete(place_of(file, role), *definition);
}

template <class Where>
void DbcDefinitions::complete_all(std::vector<Where>& all, DbcObject object) const {
  const auto roles = meant(object);
  for (auto& one : all)
    for (const auto& [role, definition] : roles) complete(place_of(one, role), *definition);
}

void DbcDefinitions::complete_signals(DbcFile& file) const {
  const auto roles = meant(DbcObject::signal);
  for (auto& message : file.messages)
    for (const Meant& one : roles)
      if (auto* const values = values_of_signals(message, one.role); values != nullptr)
        complete(*values, message.signals, *one.definition);
}

void DbcDefinitions::complete(DbcSignalValues& values, std::size_t signals,
                              const Definition& definition) {
  std::vector<DbcValue> all(values.different.begin(), values.different.end());
  if (values.stated < signals) all.emplace_back();  // the others have the default
  values.different.clear();
  for (DbcValue& value : all) {
    complete(&value, definition);
    if (value) values.different.insert(std::move(*value));
  }
}

void DbcDefinitions::complete(DbcValue* value, const Definition& definition) {
  if (value == nullptr) return;
  if (!*value) *value = definition.otherwise;
  if (!*value || definition.words.empty()) return;
  if (const auto number = number_in<std::size_t>(**value);
      number && *number < definition.words.size())
    *value = definition.words[*number];
}

}  // namespace mlcca::tools::design
