// SPDX-License-Identifier: BSD-2-Clause
// One transaction through mlcca-cluster against the same by libcurl in this process, in turns, on
// an etcd of one member with TLS and roles; then how long it takes to catch up. Run beside
// mlcca-cluster (BUILD/bench/cluster_bench).
#include <fmt/core.h>

#include <chrono>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "cluster/http.hpp"
#include "tests/bench/gateways/direct.hpp"
#include "tests/bench/measure.hpp"
#include "tests/cluster/gateway.hpp"
#include "tests/cluster/store.hpp"

namespace {

using namespace mlcca;
using bench::quantile;
using core::cluster::Compare;
using core::cluster::Outcome;
using core::cluster::Txn;
using Clock = std::chrono::steady_clock;

constexpr int kRounds = 2000;
constexpr std::uint64_t kEntries = 100'000;
constexpr std::size_t kInOne = 100;

double since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// One comparison that holds, two values of 200 octets, one read.
Txn transaction(std::uint64_t id, const std::string& key, std::int64_t revision) {
  const std::string own = "/mlcca/t/r/gw1/" + key;
  return {.id = id,
          .compares = {{.what = Compare::What::mod,
                        .is = Compare::Is::equal,
                        .key = own,
                        .revision = revision}},
          .puts = {{.key = own, .value = std::string(200, 'x')},
                   {.key = own + "2", .value = std::string(200, 'x')}},
          .deletes = {},
          .else_get = {own},
          .patience_ns = 5'000'000'000};
}

[[noreturn]] void give_up(const std::string& why) {
  fmt::print(stderr, "{}\n", why);
  std::exit(1);
}

std::int64_t run(const test::Loop& loop, test::Gateway& gateway, const Txn& txn) {
  gateway.link.send(txn);
  loop.until([&] { return gateway.results.contains(txn.id); });
  const auto result = gateway.results.extract(txn.id);
  if (result.empty() || result.mapped().outcome != Outcome::committed)
    give_up("a transaction failed: " + (result.empty() ? "no answer" : result.mapped().why));
  return result.mapped().revision;
}

void fill(const test::Loop& loop, test::Gateway& gateway) {
  for (std::uint64_t at = 0; at < kEntries; at += kInOne) {
    Txn txn{.id = at,
            .compares = {},
            .puts = {},
            .deletes = {},
            .else_get = {},
            .patience_ns = 5'000'000'000};
    for (std::size_t i = 0; i < kInOne; ++i)
      txn.puts.push_back({.key = fmt::format("/mlcca/t/r/gw1/many/{:08}", at + i),
                          .value = std::string(300, 'r')});
    run(loop, gateway, txn);
  }
}

}  // namespace

int main() {
  if (auto prepared = cluster::prepare_http(); !prepared) give_up(prepared.error().text);
  const test::WorkFolder folder;
  test::make_certificates(folder);
  const test::Store store(folder, 1);
  const test::Loop loop;
  const test::Bridged bridged(folder, "gw1", {store.endpoint(0)});
  test::Gateway gateway(loop.get(), bridged.socket());
  if (!loop.until([&] { return gateway.state.reachable; })) give_up(gateway.state.problem);
  bench::Direct bare(loop, bench::settings_of(folder, "gw1"), store.endpoint(0));

  std::vector<double> directly;
  std::vector<double> bridged_times;
  std::int64_t first = 0;
  std::int64_t second = 0;
  for (int i = 0; i < kRounds; ++i) {
    auto start = Clock::now();
    first = bare.run(transaction(1, "bare", first));
    directly.push_back(since(start));
    start = Clock::now();
    second = run(loop, gateway, transaction(1, "bridged", second));
    bridged_times.push_back(since(start));
  }
  for (const double part : {0.5, 0.99})
    fmt::print(
        "a transaction through mlcca-cluster, p{:<8.0f} {:8.3f} ms   by libcurl alone {:8.3f} ms   "
        "ratio {:.2f}\n",
        part * 100, quantile(bridged_times, part), quantile(directly, part),
        quantile(bridged_times, part) / quantile(directly, part));

  fill(loop, gateway);
  const auto start = Clock::now();
  gateway.link.follow({"/mlcca/t/r/gw1/many/"});
  if (!loop.until([&] { return gateway.synced != 0; })) give_up("no snapshot");
  fmt::print("catching up with {} entries of 300 octets {:8.0f} ms\n", gateway.entries.size(),
             since(start));
}
