// SPDX-License-Identifier: BSD-2-Clause
// The telnet interface of olsrd2 answers a line that begins with '/' with the output of each of its
// commands and closes. "json" makes each output an object with one array; numbers of the raw
// metrics are integers, everything else is text ("-": no address).
#include "daemon/net/sources/olsr.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "daemon/net/sources/line_client.hpp"

namespace mlcca::net {
namespace olsr {
namespace {

using nlohmann::json;

constexpr std::uint64_t kWorstMetric = 0xffff00;  // RFC 7181, 4.2 and 6.2

bool is_v6(std::string_view address) { return address.find(':') != std::string_view::npos; }

/// Text of a key, empty when it is missing or "-".
std::string text_of(const json& row, const char* key) {
  const std::string text = row.value(key, "-");
  return text == "-" ? std::string{} : text;
}

/// What the rows of the three tables say, before it is known who we are.
struct Tables {
  std::vector<std::string> own;  ///< at most one address of each family
  json neighbours = json::array();
  json edges = json::array();
};

core::mesh::Sample link(std::string from, std::string to, const json& row, const char* raw_metric) {
  core::mesh::Sample sample;
  sample.from = std::move(from);
  sample.to = std::move(to);
  sample.kind = core::mesh::RateKind::derived;
  const auto metric = row.value(raw_metric, std::uint64_t{0});
  if (text_of(row, "domain_metric") == "ff_dat_metric") sample.rate = rate_of(metric);
  sample.weight = metric;
  return sample;
}

bool is_cost(const json& row, const char* raw_metric) {
  const auto metric = row.value(raw_metric, std::uint64_t{0});
  return metric >= 1 && metric <= kWorstMetric;
}

Tables read_tables(std::string_view answer) {
  Tables tables;
  std::istringstream in{std::string(answer)};
  while (in >> std::ws && !in.eof()) {
    json table;
    in >> table;
    for (const auto& row : table.value("originator", json::array()))
      if (auto address = text_of(row, "originator"); !address.empty())
        tables.own.push_back(std::move(address));
    if (table.contains("neighbor")) tables.neighbours = table["neighbor"];
    if (table.contains("edge")) tables.edges = table["edge"];
  }
  return tables;
}

core::mesh::Snapshot snapshot_of(const Tables& tables) {
  core::mesh::Snapshot out;
  for (const auto& row : tables.neighbours) {
    const std::string neighbour = text_of(row, "neighbor_originator");
    if (neighbour.empty() || text_of(row, "neighbor_symmetric") != "true") continue;
    for (const auto& own : tables.own) {
      if (is_v6(own) != is_v6(neighbour)) continue;
      if (is_cost(row, "domain_metric_out_raw"))
        out.links.push_back(link(own, neighbour, row, "domain_metric_out_raw"));
      if (is_cost(row, "domain_metric_in_raw"))
        out.links.push_back(link(neighbour, own, row, "domain_metric_in_raw"));
    }
  }
  for (const auto& row : tables.edges) {
    std::string from = text_of(row, "node");
    std::string to = text_of(row, "edge");
    // Of a link to us we have just read what is younger: our own count.
    const bool known = std::ranges::find(tables.own, to) != tables.own.end();
    if (from.empty() || to.empty() || known || !is_cost(row, "domain_metric_out_raw")) continue;
    out.links.push_back(link(std::move(from), std::move(to), row, "domain_metric_out_raw"));
  }
  return out;
}

}  // namespace

Value rate_of(std::uint64_t metric) {
  if (metric < 1 || metric > kWorstMetric) return 0;
  return (Value{1} << 31U) / metric;
}

Result<core::mesh::Snapshot> parse(std::string_view answer) {
  try {
    const Tables tables = read_tables(answer);
    if (tables.own.empty()) return fail("it does not say which node it is");
    return snapshot_of(tables);
  } catch (const json::exception& e) {
    return fail(std::string("its answer is not understood: ") + e.what());
  }
}

}  // namespace olsr

namespace {

constexpr std::uint64_t kInterval = 2'000'000;  // µs
constexpr std::uint64_t kPatience = 5'000'000;  // µs
constexpr std::size_t kLongestAnswer = std::size_t{16} << 20;

/// Asks, reads until olsrd2 closes, and comes back.
class Olsr final : public LinkSource {
 public:
  Olsr(Endpoint endpoint, sd_event* loop, Report report)
      : text_(endpoint.text),
        loop_(loop),
        report_(std::move(report)),
        client_(std::move(endpoint), kInterval, kPatience,
                {.connected = [this] { client_.send(olsr::kRequest); },
                 .line = [this](std::string_view line) { take(line); },
                 .ended = [this](const std::string& why) { ended(why); }}) {}

  Result<void> start() { return client_.start(loop_); }

 private:
  void take(std::string_view line) {
    answer_.append(line).push_back('\n');
    if (answer_.size() > kLongestAnswer) client_.end("its answer is too long");
  }

  void ended(const std::string& why) {
    const std::string answer = std::exchange(answer_, {});
    auto read = why.empty() ? olsr::parse(answer) : fail(why);
    core::mesh::Snapshot snapshot;
    if (read)
      snapshot = std::move(*read);
    else
      snapshot.problem = "olsrd2 at " + text_ + ": " + read.error().text;
    stamp(snapshot, time_of(loop_));
    report_(std::move(snapshot));
  }

  std::string text_;
  sd_event* loop_;
  Report report_;
  std::string answer_;
  LineClient client_;
};

}  // namespace

Result<std::unique_ptr<LinkSource>> open_olsr(const core::mesh::Source& source, sd_event* loop,
                                              LinkSource::Report report) {
  auto endpoint = parse_endpoint(source.endpoint);
  if (!endpoint) return std::unexpected(endpoint.error());
  auto olsr = std::make_unique<Olsr>(std::move(*endpoint), loop, std::move(report));
  if (auto started = olsr->start(); !started) return std::unexpected(started.error());
  return olsr;
}

}  // namespace mlcca::net
