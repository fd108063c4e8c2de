// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/keys.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "base/number.hpp"

namespace mlcca::core::cluster {
namespace {

constexpr std::string_view kHexDigits = "0123456789abcdef";
constexpr std::size_t kDigestDigits = 64;

bool stands_for_itself(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '_' || c == '-';
}

/// Separates the parts of a key; returns 0 if there are more than a key has.
std::size_t split(std::string_view text, std::array<std::string_view, 4>& words) {
  std::size_t count = 0;
  while (count < words.size()) {
    const auto slash = text.find('/');
    words[count++] = text.substr(0, slash);
    if (slash == std::string_view::npos) return count;
    text.remove_prefix(slash + 1);
  }
  return 0;
}

/// Parses a number as to_string() writes it, so that each number has one form.
std::optional<std::uint64_t> plain_number(std::string_view text) {
  const auto number = number_in<std::uint64_t>(text);
  return number && (text.size() == 1 || text.front() != '0') ? number : std::nullopt;
}

template <class Names>
std::optional<std::size_t> index_in(const Names& names, std::string_view name) {
  const auto it = names.find(name);
  return it == names.end() ? std::nullopt : std::optional(it->second);
}

bool is_digest(std::string_view text) {
  return text.size() == kDigestDigits &&
         text.find_first_not_of(kHexDigits) == std::string_view::npos;
}

}  // namespace

std::string hex_of(std::string_view octets) {
  std::string out;
  for (const char c : octets) {
    const auto octet = static_cast<std::uint8_t>(c);
    out += kHexDigits[octet >> 4U];
    out += kHexDigits[octet & 0xfU];
  }
  return out;
}

std::string encoded(std::string_view name) {
  std::string out;
  for (const char c : name) {
    if (stands_for_itself(c)) {
      out += c;
      continue;
    }
    out += '%';
    out += hex_of({&c, 1});
  }
  return out;
}

Keys::Keys(const System& system, std::string prefix) : prefix_(std::move(prefix)) {
  for (const Gateway& gateway : system.gateways) {
    gateway_of_.emplace(encoded(gateway.name), gateways_.size());
    gateways_.push_back(encoded(gateway.name));
    gateway_names_.push_back(gateway.name);
  }
  for (const Network& network : system.networks) {
    network_of_.emplace(encoded(network.name), networks_.size());
    networks_.push_back(encoded(network.name));
  }
  beside_.assign(gateways_.size() * gateways_.size(), false);
  for (std::size_t g = 0; g < gateways_.size(); ++g)
    for (std::size_t other = 0; other < gateways_.size(); ++other) {
      std::size_t both = 0;
      for (std::size_t n = 0; n < networks_.size(); ++n)
        both += system.gateways[g].port_on(n) && system.gateways[other].port_on(n) ? 1 : 0;
      beside_[(g * gateways_.size()) + other] = g != other && both > 1;
    }
}

std::string Keys::blob(std::string_view digest, std::uint64_t number) const {
  return prefix_ + "d/blob/" + std::string(digest) + '/' + std::to_string(number);
}
std::string Keys::rollout_vote(std::size_t gateway) const {
  return prefix_ + "d/vote/" + gateways_[gateway];
}
std::string Keys::member(std::size_t gateway) const { return prefix_ + "m/" + gateways_[gateway]; }
std::string Keys::fence(std::size_t gateway) const { return prefix_ + "f/" + gateways_[gateway]; }
std::string Keys::version(std::size_t network) const { return prefix_ + "v/" + networks_[network]; }
std::string Keys::reservation(std::size_t network, std::size_t gateway, std::uint64_t id) const {
  return prefix_ + "r/" + networks_[network] + '/' + gateways_[gateway] + '/' + std::to_string(id);
}
std::string Keys::asked(std::size_t gateway, std::uint64_t id) const {
  return prefix_ + "x/" + gateways_[gateway] + '/' + std::to_string(id);
}
std::string Keys::vote(std::size_t gateway, std::size_t from, std::uint64_t id) const {
  return prefix_ + "a/" + gateways_[gateway] + '/' + gateways_[from] + '/' + std::to_string(id);
}

std::optional<std::size_t> Keys::gateway(std::string_view name) const {
  return index_in(gateway_of_, encoded(name));
}

std::optional<Key> Keys::parse(std::string_view key) const {
  if (!key.starts_with(prefix_)) return std::nullopt;
  Words words;
  const std::size_t count = split(key.substr(prefix_.size()), words);
  const std::string_view first = words[0];
  if (count == 1) return first == "e" ? std::optional(Key{}) : std::nullopt;
  if (first == "d") return parse_description(words, count);
  if (count == 2) return parse_pair(first, words[1]);
  return count < 3 ? std::nullopt : parse_admission(words, count);
}

std::optional<Key> Keys::parse_description(const Words& words, std::size_t count) const {
  if (count == 2 && words[1] == "current") return Key{.kind = Key::Kind::current};
  if (count == 2 && words[1] == "next") return Key{.kind = Key::Kind::next};
  if (count == 3 && words[1] == "vote") {
    const auto gateway = index_in(gateway_of_, words[2]);
    if (gateway) return Key{.kind = Key::Kind::rollout_vote, .gateway = *gateway};
  }
  if (count != 4 || words[1] != "blob" || !is_digest(words[2])) return std::nullopt;
  const auto number = plain_number(words[3]);
  if (!number) return std::nullopt;
  return Key{.kind = Key::Kind::blob, .id = *number, .digest = std::string(words[2])};
}

std::optional<Key> Keys::parse_pair(std::string_view kind, std::string_view name) const {
  if (kind == "v") {
    const auto network = index_in(network_of_, name);
    return network ? std::optional(Key{.kind = Key::Kind::version, .network = *network})
                   : std::nullopt;
  }
  const auto gateway = index_in(gateway_of_, name);
  if (!gateway || (kind != "m" && kind != "f")) return std::nullopt;
  return Key{.kind = kind == "m" ? Key::Kind::member : Key::Kind::fence, .gateway = *gateway};
}

std::optional<Key> Keys::parse_admission(const Words& words, std::size_t count) const {
  const auto id = plain_number(words[count - 1]);
  const auto last_name = index_in(gateway_of_, words[count - 2]);
  if (!id || !last_name) return std::nullopt;
  if (count == 3 && words[0] == "x")
    return Key{.kind = Key::Kind::asked, .gateway = *last_name, .id = *id};
  if (count != 4) return std::nullopt;
  if (words[0] == "r") {
    const auto network = index_in(network_of_, words[1]);
    if (!network) return std::nullopt;
    return Key{
        .kind = Key::Kind::reservation, .network = *network, .gateway = *last_name, .id = *id};
  }
  const auto gateway = index_in(gateway_of_, words[1]);
  if (words[0] != "a" || !gateway) return std::nullopt;
  return Key{.kind = Key::Kind::vote, .gateway = *gateway, .from = *last_name, .id = *id};
}

std::optional<LeftKey> Keys::parse_left(std::string_view key) const {
  if (!key.starts_with(prefix_)) return std::nullopt;
  Words words;
  const std::size_t count = split(key.substr(prefix_.size()), words);
  LeftKey left;
  if (count == 2 && (words[0] == "m" || words[0] == "f")) {
    left.kind = words[0] == "m" ? Key::Kind::member : Key::Kind::fence;
    left.gateway = words[1];
  } else if (count == 3 && words[0] == "x") {
    left = {.kind = Key::Kind::asked, .gateway = words[1]};
  } else if (count == 3 && words[0] == "d" && words[1] == "vote") {
    left = {.kind = Key::Kind::rollout_vote, .gateway = words[2]};
  } else if (count == 4 && words[0] == "a") {
    const auto voter = index_in(gateway_of_, words[1]);
    left = {.kind = Key::Kind::vote, .gateway = words[voter ? 2 : 1], .voter = voter};
  } else if (count == 4 && words[0] == "r") {
    left = {.kind = Key::Kind::reservation,
            .gateway = words[2],
            .network = index_in(network_of_, words[1])};
  }
  // The name may be displayed and become a part of a command.
  const bool plain =
      std::ranges::all_of(key, [](char c) { return stands_for_itself(c) || c == '%' || c == '/'; });
  return !plain || left.gateway.empty() || gateway_of_.contains(left.gateway) ? std::nullopt
                                                                              : std::optional(left);
}

bool Keys::is_of_removed_network(std::string_view key, std::size_t gateway) const {
  if (!key.starts_with(prefix_)) return false;
  Words words;
  const std::size_t count = split(key.substr(prefix_.size()), words);
  const bool own = (count == 2 && words[0] == "v") ||
                   (count == 4 && words[0] == "r" && words[2] == gateways_[gateway]);
  return own && !words[1].empty() && !network_of_.contains(words[1]);
}

std::optional<std::size_t> Keys::writer_of(std::string_view key) const {
  if (!key.starts_with(prefix_)) return std::nullopt;
  key.remove_prefix(prefix_.size());
  if (!key.starts_with("r/")) return std::nullopt;
  key.remove_prefix(2);
  key.remove_prefix(std::min(key.find('/'), key.size() - 1) + 1);
  return index_in(gateway_of_, key.substr(0, key.find('/')));
}

std::optional<std::size_t> Keys::network_of(std::string_view key) const {
  if (!key.starts_with(prefix_)) return std::nullopt;
  key.remove_prefix(prefix_.size());
  if (!key.starts_with("r/")) return std::nullopt;
  key.remove_prefix(2);
  return index_in(network_of_, key.substr(0, key.find('/')));
}

}  // namespace mlcca::core::cluster
