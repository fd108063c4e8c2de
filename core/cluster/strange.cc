// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/strange.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <ranges>

#include "core/model/text.hpp"

namespace mlcca::core::cluster {
namespace {

/// Whether a shell reads the character as itself.
bool is_plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '/' ||
         c == '%' || c == '.' || c == '_' || c == '-';
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c > ' ' && c < '\x7f' && c != '\\' && c != '\'')
      out += c;
    else
      out += "\\x" + hex_of({&c, 1});
  }
  return out;
}

/// A command for a shell that deletes the entry.
std::string deletion_of(std::string_view key) {
  if (key.size() > kMostShownKey)
    return "find its key with 'etcdctl get --prefix --keys-only " +
           escaped(key.substr(0, key.find('/', 1) + 1)) + "', and delete it";
  return "etcdctl del " +
         (std::ranges::all_of(key, is_plain) ? std::string(key) : "$'" + escaped(key) + "'");
}

std::string why_strange(const Records& records, const Keys& keys, const std::optional<Key>& key,
                        const StrangeEntry& entry) {
  switch (entry.why) {
    case Strangeness::key:
      return "the description has nothing of that name";
    case Strangeness::too_long:
      return "it has " + std::to_string(entry.octets) + " octets, and may have " +
             std::to_string(kMostEntryBytes);
    case Strangeness::value: {
      std::string what = "it is damaged, or of another version";
      if (!key || key->kind != Key::Kind::member) return what;
      return what + ": " + keys.gateway_name(key->gateway) + " counts as sending for " +
             format_span(kMostLease) + " from then on";
    }
    case Strangeness::other:
      return "it belongs to another description";
    case Strangeness::lease: {
      if (!key) break;
      const Value lease = records.members[key->gateway].lease;
      const std::string stated = "it states a lease of " + format_span(lease);
      return lease < kLeastLease ? stated + ", and " + format_span(kLeastLease) + " is the shortest"
                                 : stated + ", and " + format_span(kMostLease) +
                                       " is the longest: " + keys.gateway_name(key->gateway) +
                                       " counts as sending for so long";
    }
  }
  return {};
}

/// What an operator can do about it.
std::string remedy(const Keys& keys, std::string_view name, const std::optional<Key>& key,
                   const StrangeEntry& entry) {
  const bool written_by_one = key && key->kind != Key::Kind::epoch &&
                              key->kind != Key::Kind::current && key->kind != Key::Kind::next &&
                              key->kind != Key::Kind::blob && key->kind != Key::Kind::version;
  if (entry.why == Strangeness::other && key)
    return keys.gateway_name(key->gateway) +
           " gives it back when it has the description in force; 'mlccactl cluster members' shows "
           "which one each gateway has";
  if (entry.why == Strangeness::lease && key)
    return "restart mlccad on " + keys.gateway_name(key->gateway) + " with a --lease of " +
           format_span(kLeastLease) + " to " + format_span(kMostLease);
  if (key && key->kind == Key::Kind::member)
    return "'mlccactl cluster status' on " + keys.gateway_name(key->gateway) +
           " says what to do; if mlccad does not run there, start it, which replaces the entry";
  if (written_by_one)
    return "restart mlccad on " + keys.gateway_name(key->gateway) +
           ", which replaces or deletes it; if that gateway is off, the others do so when its "
           "lease has ended";
  if (keys.parse_left(name)) return "'mlccactl cluster members' says how to delete it, and when";
  if (key) return {};
  return "delete it as root of etcd: " + deletion_of(name);
}

std::string whose(const Keys& keys, std::string_view name, const std::optional<Key>& key) {
  if (const auto left = key ? std::nullopt : keys.parse_left(name))
    return " of " + shown_key(left->gateway) + ", which is not in the description";
  std::optional<std::size_t> gateway = key ? std::nullopt : keys.writer_of(name);
  if (key && key->kind != Key::Kind::epoch && key->kind != Key::Kind::current &&
      key->kind != Key::Kind::next)
    gateway = key->gateway;
  return gateway ? " of gateway " + keys.gateway_name(*gateway) : std::string();
}

std::string words_of(const Records& records, const Keys& keys, const std::string& name,
                     const StrangeEntry& entry, std::size_t more) {
  const auto key = keys.parse(name);
  std::string out = shown_key(name) + whose(keys, name, key) + " (" +
                    why_strange(records, keys, key, entry) + ")";
  if (more != 0)
    out += " and " + std::to_string(more) + (more == 1 ? " more entry" : " more entries");
  const std::string what = remedy(keys, name, key, entry);
  return what.empty() ? out : out + ": " + what;
}

template <class Counts>
std::string first_of(const Records& records, const Keys& keys, Counts counts) {
  const std::string* first = nullptr;
  std::size_t more = 0;
  for (const auto& [name, entry] : records.strange) {
    if (!counts(name, entry)) continue;
    if (first == nullptr)
      first = &name;
    else
      ++more;
  }
  if (first == nullptr) return {};
  return words_of(records, keys, *first, records.strange.at(*first), more);
}

/// ", 180000 of them of gw2", for the gateway that has the most.
std::string most_are_of(const Keys& keys, const std::map<std::size_t, std::size_t>& counts) {
  const auto most =
      std::ranges::max_element(counts, {}, [](const auto& count) { return count.second; });
  if (most == counts.end()) return {};
  return ", " + std::to_string(most->second) + " of them of " + keys.gateway_name(most->first);
}

}  // namespace

std::string shown_key(std::string_view key) {
  return key.size() <= kMostShownKey ? escaped(key) : escaped(key.substr(0, kMostShownKey)) + "...";
}

std::string unreadable_words(const Records& records, const Keys& keys, std::size_t network) {
  if (records.too_many != Exceeded::no) return too_many_words(records, keys);
  return first_of(records, keys, [&](const std::string&, const StrangeEntry& entry) {
    return entry.network == std::optional(network);
  });
}

std::string unreadable_words(const Records& records, const Keys& keys) {
  return first_of(records, keys, [&](const std::string& name, const StrangeEntry& entry) {
    return !entry.network && keys.parse(name).has_value();
  });
}

std::string too_many_words(const Records& records, const Keys& keys) {
  std::map<std::size_t, std::size_t> counts;
  std::string out;
  switch (records.too_many) {
    case Exceeded::no:
      return {};
    case Exceeded::reservations:
      for (const auto& key : std::views::keys(records.reservations)) ++counts[key.gateway];
      out = "more than " + std::to_string(kMostReservations) + " reservations" +
            most_are_of(keys, counts) + ": drain that gateway";
      break;
    case Exceeded::strange:
      for (const auto& name : std::views::keys(records.strange)) {
        const auto key = keys.parse(name);
        const auto gateway = key ? std::optional(key->gateway) : keys.writer_of(name);
        if (gateway) ++counts[*gateway];
      }
      out = "more than " + std::to_string(kMostStrange) + " entries that cannot be read" +
            most_are_of(keys, counts) + ", the first is " +
            shown_key(records.strange.empty() ? "" : records.strange.begin()->first) +
            ": delete them as root of etcd";
      break;
    case Exceeded::changes:
      out = "more changes at one revision than a gateway makes";
      break;
  }
  return out + "; then 'systemctl restart mlcca-cluster' here reads everything again";
}

}  // namespace mlcca::core::cluster
