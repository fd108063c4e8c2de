// SPDX-License-Identifier: BSD-2-Clause
// A store in memory: keys with revisions, transactions, and what has changed at each revision.
#pragma once
#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/cluster/store.hpp"

namespace mlcca::core::cluster::test {

struct StoreStub {
  std::map<std::string, Entry> entries;
  std::int64_t revision = 1;
  std::vector<Batch> log;              ///< since it was compacted, in order of revisions
  std::vector<std::string> forbidden;  ///< beginnings of keys that nobody may write

  [[nodiscard]] std::int64_t mod(const std::string& key) const {
    const auto it = entries.find(key);
    return it == entries.end() ? 0 : it->second.mod;
  }
  [[nodiscard]] bool holds(const Compare& c) const {
    const auto it = entries.find(c.key);
    const std::int64_t have = it == entries.end()            ? 0
                              : c.what == Compare::What::mod ? it->second.mod
                                                             : it->second.create;
    return c.is == Compare::Is::equal ? have == c.revision : have < c.revision;
  }

  [[nodiscard]] bool is_forbidden(const Txn& txn) const {
    const auto is = [this](const std::string& key) {
      return std::ranges::any_of(forbidden,
                                 [&](const std::string& one) { return key.starts_with(one); });
    };
    return std::ranges::any_of(txn.deletes, is) ||
           std::ranges::any_of(txn.puts, [&](const Put& put) { return is(put.key); });
  }

  TxnResult apply(const Txn& txn) {
    TxnResult result{.id = txn.id, .outcome = Outcome::committed, .why = {}};
    if (is_forbidden(txn)) {
      result.outcome = Outcome::forbidden;
      result.why = "permission denied";
      return result;
    }
    for (const Compare& c : txn.compares)
      if (!holds(c)) result.outcome = Outcome::conflict;
    if (result.outcome == Outcome::conflict) {
      result.revision = revision;
      for (const std::string& key : txn.else_get)
        if (const auto it = entries.find(key); it != entries.end())
          result.read.push_back(it->second);
        else
          result.read.push_back({.key = key, .value = {}, .gone = true});
      return result;
    }
    write(txn.puts, txn.deletes);
    result.revision = revision;
    return result;
  }
  void write(const std::vector<Put>& puts, const std::vector<std::string>& deletes = {}) {
    Batch batch{.revision = ++revision, .entries = {}};
    for (const Put& put : puts) {
      Entry& entry = entries[put.key];
      entry = {.key = put.key,
               .value = put.value,
               .create = entry.create == 0 ? revision : entry.create,
               .mod = revision};
      batch.entries.push_back(entry);
    }
    for (const std::string& key : deletes)
      if (entries.erase(key) != 0)
        batch.entries.push_back({.key = key, .value = {}, .mod = revision, .gone = true});
    log.push_back(std::move(batch));
  }
  [[nodiscard]] Batch snapshot() const {
    Batch all{.revision = revision, .entries = {}};
    for (const auto& [key, entry] : entries) all.entries.push_back(entry);
    return all;
  }
};

}  // namespace mlcca::core::cluster::test
