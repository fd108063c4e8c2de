// SPDX-License-Identifier: BSD-2-Clause
// The keys under which applications asked for admissions, so that a repeated request does not make
// a second admission.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace mlcca {

/// The prefix of the keys of subscriptions that came over a network.
[[nodiscard]] inline std::string subscription_keys(const std::string& network) {
  return "subscription " + network + " ";
}

/// A map between keys and admission numbers, in both directions.
class Keys {
 public:
  /// An empty key is not remembered.
  void put(const std::string& key, std::uint64_t id) {
    if (key.empty()) return;
    ids_.insert_or_assign(key, id);
    keys_.insert_or_assign(id, key);
  }
  [[nodiscard]] std::optional<std::uint64_t> find(const std::string& key) const {
    const auto known = ids_.find(key);
    if (known == ids_.end()) return std::nullopt;
    return known->second;
  }
  [[nodiscard]] std::size_t count_with_prefix(const std::string& prefix) const {
    std::size_t n = 0;
    for (auto at = ids_.lower_bound(prefix); at != ids_.end() && at->first.starts_with(prefix);
         ++at)
      ++n;
    return n;
  }
  void forget(std::uint64_t id) {
    const auto known = keys_.find(id);
    if (known == keys_.end()) return;
    ids_.erase(known->second);
    keys_.erase(known);
  }

 private:
  std::map<std::string, std::uint64_t> ids_;
  std::map<std::uint64_t, std::string> keys_;
};

}  // namespace mlcca
