// SPDX-License-Identifier: BSD-2-Clause
#include "tests/cluster/gateway.hpp"

#include <unistd.h>

#include <utility>
#include <variant>

#include "tests/support/becomes.hpp"
#include "tests/support/require.hpp"

namespace mlcca::test {

using core::cluster::Batch;
using core::cluster::Compare;
using core::cluster::StoreState;
using core::cluster::Txn;
using core::cluster::TxnResult;

Loop::Loop() {
  sd_event* raw = nullptr;
  require(sd_event_new(&raw) >= 0, "sd_event_new");
  loop_.reset(raw);
}

bool Loop::until(const std::function<bool()>& holds, std::chrono::milliseconds patience) const {
  constexpr std::uint64_t round = 50'000;  // µs
  const auto start = std::chrono::steady_clock::now();
  while (!holds()) {
    if (std::chrono::steady_clock::now() - start > patience) return false;
    sd_event_run(loop_.get(), round);
  }
  return true;
}

Gateway::Gateway(sd_event* loop, const std::string& socket, std::vector<std::string> prefixes)
    : link(loop, {.socket = socket, .hello = {"t", "gw"}, .pause = 50'000}) {
  link.on_message([this](ClusterMessage message) { take(std::move(message)); });
  if (!prefixes.empty()) link.follow(std::move(prefixes));
  require(link.start().has_value(), "the link");
}

void Gateway::take(ClusterMessage message) {
  if (const auto* said = std::get_if<StoreState>(&message)) {
    state = *said;
    states.push_back(*said);
  } else if (const auto* snapshot = std::get_if<ClusterSnapshot>(&message)) {
    ++snapshots;
    entries.clear();
    changes.clear();
    synced = 0;
    begun = revision = snapshot->revision;
  } else if (const auto* end = std::get_if<ClusterSynced>(&message)) {
    synced = end->revision;
  } else if (auto* batch = std::get_if<Batch>(&message)) {
    revision = batch->revision;
    for (const auto& entry : batch->entries) {
      if (entry.gone)
        entries.erase(entry.key);
      else
        entries.insert_or_assign(entry.key, entry);
    }
    if (synced != 0) changes.push_back(std::move(*batch));
  } else {
    auto& result = std::get<TxnResult>(message);
    const std::uint64_t id = result.id;
    results.insert_or_assign(id, std::move(result));
  }
}

Bridged::Bridged(const WorkFolder& folder, const std::string& user,
                 const std::vector<std::string>& endpoints, const std::string& more) {
  static int number = 0;
  const std::string name = "bridge" + std::to_string(++number);
  socket_ = folder / name;
  log_ = folder / (name + ".log");
  std::string settings;
  for (const auto& endpoint : endpoints) settings += "endpoint = " + endpoint + '\n';
  settings += "ca = " + folder / "ca.pem" + "\ncertificate = " + folder / (user + ".pem") +
              "\nkey = " + folder / (user + ".key") + '\n' + more;
  write_file(folder / (name + ".conf"), settings);
  program = Program(
      {built("mlcca-cluster"), "--settings", folder / (name + ".conf"), "--socket", socket_}, log_);
  require(becomes([this] { return ::access(socket_.c_str(), F_OK) == 0; }), "the socket");
}

Txn creation(std::uint64_t id, const std::vector<std::string>& keys, const std::string& value) {
  Txn txn{.id = id,
          .compares = {},
          .puts = {},
          .deletes = {},
          .else_get = {},
          .patience_ns = 3'000'000'000};
  for (const auto& key : keys) {
    txn.compares.push_back(
        {.what = Compare::What::create, .is = Compare::Is::equal, .key = key, .revision = 0});
    txn.puts.push_back({.key = key, .value = value});
    txn.else_get.push_back(key);
  }
  return txn;
}

}  // namespace mlcca::test
