// SPDX-License-Identifier: BSD-2-Clause
// Parses answers of the telnet interface of olsrd2: it answers a line that begins with '/' with the
// output of each command and closes. "json" makes each output an object with one array; raw metrics
// are integers, everything else is text ("-": no address).
#include "tools/sources/olsr.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "base/loop_timer.hpp"
#include "base/throttle.hpp"
#include "tools/sources/line_client.hpp"

namespace mlcca::net {
namespace olsr {
namespace {

using nlohmann::json;

constexpr std::uint64_t kWorstMetric = 0xffff00;  // RFC 7181, 4.2 and 6.2

bool is_v6(std::string_view address) { return address.find(':') != std::string_view::npos; }

/// The known fields of a row. A text is empty if it is missing or "-".
struct Row {
  std::string originator;
  std::string neighbour;
  std::string symmetric;
  std::string node;
  std::string edge;
  std::string metric;
  std::uint64_t out = 0;
  std::uint64_t in = 0;
};

/// The rows of the three tables, before our own addresses are known.
struct Tables {
  std::vector<std::string> own;  ///< at most one address of each family
  std::vector<Row> neighbours;
  std::vector<Row> edges;
};

/// Takes {"TABLE": [{"KEY": text, number, true or false}, …], …} while it is parsed, and stops at
/// anything else: nothing else is stored, and nesting costs nothing.
class Reader : public nlohmann::json_sax<json> {
 public:
  explicit Reader(Tables& tables) : tables_(tables) {}

  [[nodiscard]] const std::string& problem() const { return problem_; }

  bool start_object(std::size_t) override {
    row_ = {};
    if (where_ == Where::outside) return enter(Where::tables);
    return where_ == Where::table ? enter(Where::row) : refuse();
  }
  bool end_object() override {
    if (where_ == Where::tables) return enter(Where::outside);
    return enter(Where::table) && take_row();
  }
  bool start_array(std::size_t) override {
    return where_ == Where::tables ? enter(Where::table) : refuse();
  }
  bool end_array() override { return enter(Where::tables); }
  bool key(std::string& name) override {
    if (name.size() > core::mesh::kMaxAddress) return refuse();
    (where_ == Where::tables ? table_ : key_) = name;
    return true;
  }
  bool string(std::string& text) override {
    if (where_ != Where::row || text.size() > kMaxText) return refuse();
    if (std::string* const field = text_field()) *field = text == "-" ? std::string{} : text;
    return number_field() == nullptr || refuse();
  }
  bool number_unsigned(std::uint64_t number) override {
    if (where_ != Where::row || text_field() != nullptr) return refuse();
    if (std::uint64_t* const field = number_field()) *field = number;
    return true;
  }
  bool null() override { return other(); }
  bool boolean(bool) override { return other(); }
  bool number_integer(std::int64_t) override { return other(); }
  bool number_float(double, const std::string&) override { return other(); }
  bool binary(json::binary_t&) override { return refuse(); }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override {
    if (problem_.empty()) problem_ = "its answer is not understood: it is no JSON";
    return false;
  }

 private:
  enum class Where : std::uint8_t { outside, tables, table, row };

  bool enter(Where where) {
    where_ = where;
    return true;
  }
  bool refuse() {
    problem_ =
        "its answer is not understood: it holds something else than tables of texts and "
        "numbers";
    return false;
  }
  /// Takes a value of a type that none of our fields has.
  bool other() {
    return where_ == Where::row && text_field() == nullptr && number_field() == nullptr ? true
                                                                                        : refuse();
  }
  std::string* text_field() {
    if (key_ == "originator") return &row_.originator;
    if (key_ == "neighbor_originator") return &row_.neighbour;
    if (key_ == "neighbor_symmetric") return &row_.symmetric;
    if (key_ == "node") return &row_.node;
    if (key_ == "edge") return &row_.edge;
    return key_ == "domain_metric" ? &row_.metric : nullptr;
  }
  std::uint64_t* number_field() {
    if (key_ == "domain_metric_out_raw") return &row_.out;
    return key_ == "domain_metric_in_raw" ? &row_.in : nullptr;
  }
  bool take_row() {
    if (++rows_ > kMaxRows) {
      problem_ = "its tables have more than " + std::to_string(kMaxRows) + " rows";
      return false;
    }
    if (table_ == "originator" && !row_.originator.empty()) {
      tables_.own.push_back(std::move(row_.originator));
      if (tables_.own.size() > kMaxOwn) return refuse();
    }
    if (table_ == "neighbor") tables_.neighbours.push_back(std::move(row_));
    if (table_ == "edge") tables_.edges.push_back(std::move(row_));
    return true;
  }

  Tables& tables_;
  Where where_ = Where::outside;
  std::string table_;
  std::string key_;
  Row row_;
  std::size_t rows_ = 0;
  std::string problem_;
};

core::mesh::Sample link(std::string from, std::string to, const Row& row, std::uint64_t metric) {
  core::mesh::Sample sample;
  sample.from = std::move(from);
  sample.to = std::move(to);
  sample.kind = core::mesh::RateKind::derived;
  if (row.metric == "ff_dat_metric") sample.rate = rate_of(metric);
  sample.weight = metric;
  return sample;
}

bool is_cost(std::uint64_t metric) { return metric >= 1 && metric <= kWorstMetric; }

Result<Tables> read_tables(std::string_view answer) {
  Tables tables;
  Reader reader(tables);
  std::istringstream in{std::string(answer)};
  while (in >> std::ws && !in.eof())
    if (!json::sax_parse(in, &reader, json::input_format_t::json, false))
      return fail(reader.problem());
  return tables;
}

core::mesh::Snapshot snapshot_of(const Tables& tables) {
  core::mesh::Snapshot out;
  for (const Row& row : tables.neighbours) {
    if (row.neighbour.empty() || row.symmetric != "true") continue;
    for (const auto& own : tables.own) {
      if (is_v6(own) != is_v6(row.neighbour)) continue;
      if (is_cost(row.out)) out.links.push_back(link(own, row.neighbour, row, row.out));
      if (is_cost(row.in)) out.links.push_back(link(row.neighbour, own, row, row.in));
    }
  }
  for (const Row& row : tables.edges) {
    // For a link to us the neighbour table has our own count, which is more recent.
    const bool known = std::ranges::find(tables.own, row.edge) != tables.own.end();
    if (row.node.empty() || row.edge.empty() || known || !is_cost(row.out)) continue;
    out.links.push_back(link(row.node, row.edge, row, row.out));
  }
  return out;
}

}  // namespace

Value rate_of(std::uint64_t metric) {
  if (metric < 1 || metric > kWorstMetric) return 0;
  return (Value{1} << 31U) / metric;
}

Result<core::mesh::Snapshot> parse(std::string_view answer) {
  const auto tables = read_tables(answer);
  if (!tables) return std::unexpected(tables.error());
  if (tables->own.empty()) return fail("it does not say which node it is");
  return snapshot_of(*tables);
}

}  // namespace olsr

namespace {

constexpr std::uint64_t kInterval = 2'000'000;  // µs
constexpr std::uint64_t kPatience = 5'000'000;  // µs

/// Sends the request, reads until olsrd2 closes, and connects again after a pause.
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
  void take(std::string_view line) { answer_.append(line).push_back('\n'); }

  void ended(const std::string& why) {
    const std::string answer = std::exchange(answer_, {});
    auto read = why.empty() ? olsr::parse(answer) : fail(why);
    core::mesh::Snapshot snapshot;
    if (read)
      snapshot = std::move(*read);
    else
      snapshot.problem = "olsrd2 at " + text_ + ": " + read.error().text;
    stamp(snapshot, loop_time(loop_));
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
