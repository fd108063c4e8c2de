// SPDX-License-Identifier: BSD-2-Clause
// The links become a chain of nodes 1, 2, 3, …, which is evaluated as the daemon evaluates a route.
#include "tools/bandwidth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string_view>

#include "base/many.hpp"
#include "base/number.hpp"
#include "core/mesh/evaluation.hpp"
#include "core/mesh/route.hpp"
#include "mlcca/arithmetic.hpp"
#include "tools/values.hpp"

namespace mlcca::tools {
namespace {

namespace mesh = core::mesh;
using Json = nlohmann::ordered_json;

constexpr Value kBitsPerByte = 8;
constexpr std::uint32_t kMaxHopDistance = 16;

struct Question {
  mesh::Mesh mesh;
  mesh::Graph graph;
  Value background = 0;         ///< medium time that each domain has lost to other traffic, ps/s
  std::optional<Value> demand;  ///< bytes/s
  bool detailed = false;        ///< more than the paper's equation was requested
};

/// Parses an option into `target`; an empty text leaves `target` unchanged.
template <class Target, class Parse>
Result<void> read(std::string_view option, const std::string& text, Target& target, Parse parse) {
  if (text.empty()) return {};
  const auto value = parse(text);
  if (!value) return fail(fmt::format("{} {}", option, value.error().text));
  target = static_cast<std::remove_cvref_t<decltype(target)>>(*value);
  return {};
}

/// Parses --domain: "single-domain" or "2-hop".
Result<void> read_domain(const std::string& text, mesh::Mesh& to) {
  if (text.empty() || text == "single-domain") return {};
  std::string_view rest = text;
  const auto hops = take_number<std::uint32_t>(rest);
  if (!hops || rest != "-hop" || *hops > kMaxHopDistance)
    return fail(fmt::format("--domain '{}': must be single-domain, or 0-hop to {}-hop", text,
                            kMaxHopDistance));
  to.interference = mesh::Interference::k_hop;
  to.hops = *hops;
  return {};
}

Result<Value> parse_loss(std::string_view text) {
  return parse_share(text, kCertainLoss, Rounding::up);
}

/// Appends a link to the chain: RATE or RATE:LOSS, with `loss` by default.
Result<void> append_link(std::string_view text, Value loss, mesh::Graph& chain) {
  const auto colon = std::min(text.find(':'), text.size());
  const auto rate = parse_bit_rate(text.substr(0, colon), Rounding::down);
  if (!rate) return std::unexpected(rate.error());
  if (colon != text.size()) {
    const auto own = parse_loss(text.substr(colon + 1));
    if (!own) return fail(fmt::format("loss of '{}': {}", text, own.error().text));
    loss = *own;
  }
  mesh::Link link;
  link.from = static_cast<std::uint32_t>(chain.links.size());
  link.to = link.from + 1;
  link.quality = {.rate = *rate, .kind = mesh::RateKind::phy, .loss = loss, .loss_known = true};
  chain.links.push_back(link);
  chain.nodes = chain.links.size() + 1;
  return {};
}

Result<void> read_links(const BandwidthArguments& from, mesh::Graph& chain) {
  if (from.rates.size() > mesh::kMaxPath)
    return fail(fmt::format("{} rates: must be at most {}", from.rates.size(), mesh::kMaxPath));
  Value loss = 0;
  if (auto good = read("--loss", from.loss, loss, parse_loss); !good) return good;
  for (const auto& rate : from.rates)
    if (auto good = append_link(rate, loss, chain); !good) return good;
  return {};
}

Result<void> read_medium(const BandwidthArguments& from, Question& to) {
  // Overheads that are not stated are 0, so that rates alone give the result of the paper.
  to.mesh.header_bytes = from.header.value_or(0);
  to.mesh.packet_bytes = from.packet.value_or(to.mesh.packet_bytes);
  const auto limit = [](const std::string& text) {
    return parse_share(text, mesh::kWhole, Rounding::down);
  };
  const auto taken = [](const std::string& text) {
    return parse_share(text, mesh::kFullTime, Rounding::up);
  };
  const auto overhead = [](const std::string& text) {
    return parse_microseconds(text, Rounding::up);
  };
  if (auto good = read("--limit", from.limit, to.mesh.limit, limit); !good) return good;
  if (auto good = read("--background", from.background, to.background, taken); !good) return good;
  if (auto good = read("--overhead-us", from.overhead, to.mesh.packet_time, overhead); !good)
    return good;
  return read_domain(from.domain, to.mesh);
}

Result<Question> understand(const BandwidthArguments& from) {
  Question result;
  if (auto good = read_links(from, result.graph); !good) return std::unexpected(good.error());
  if (auto good = read_medium(from, result); !good) return std::unexpected(good.error());
  const auto demand = [](const std::string& text) { return parse_bit_rate(text, Rounding::up); };
  if (auto good = read("--demand", from.demand, result.demand, demand); !good)
    return std::unexpected(good.error());
  if (result.demand) result.demand = div_up(*result.demand, kBitsPerByte);
  result.detailed =
      from.packet || from.header ||
      std::ranges::any_of(
          std::initializer_list<const std::string*>{&from.overhead, &from.limit, &from.background,
                                                    &from.domain, &from.demand, &from.loss},
          [](const auto* text) { return !text->empty(); }) ||
      std::ranges::any_of(
          from.rates, [](const std::string& rate) { return rate.find(':') != std::string::npos; });
  return result;
}

/// The results that are printed.
struct Numbers {
  Value paper = 0;      ///< bit/s
  Value available = 0;  ///< bit/s
  std::string limited_by;
  Value demand_time = 0;  ///< medium time, in ps/s, that the demand takes in the limiting domain
  bool fits = true;
};

Numbers evaluate(const Question& question) {
  std::vector<std::uint32_t> path(question.graph.links.size());
  std::iota(path.begin(), path.end(), 0);
  std::vector<Value> rates;
  rates.reserve(path.size());
  for (const auto& link : question.graph.links) rates.push_back(link.quality.rate);
  const mesh::Domains domains(question.graph, question.mesh);
  const mesh::PathCost cost(question.graph, question.mesh, domains, path);
  const auto rate = cost.evaluate(0, [&](std::size_t) { return question.background; });
  Numbers result;
  result.paper = mesh::paper_rate(rates);
  result.available = mul_saturating(rate.available, kBitsPerByte);
  result.limited_by = domains.name(rate.limiting_domain,
                                   [](std::uint32_t node) { return fmt::format("{}", node + 1); });
  if (!question.demand) return result;
  for (const auto& share : cost.shares(*question.demand, 0))
    if (share.domain == rate.limiting_domain) result.demand_time = share.time;
  result.fits = *question.demand <= rate.available;
  return result;
}

/// Medium time (ps/s) as a percentage, rounded up: "42.43 %".
std::string percent(Value time) {
  const Value hundredths = div_up(time, mesh::kFullTime / 10'000);
  return fmt::format("{}.{:02} %", hundredths / 100, hundredths % 100);
}

std::string to_text(const Question& question, const Numbers& numbers) {
  std::string text = print_bit_rate(numbers.paper) + "\n";
  if (!question.detailed) return text;
  const auto& mesh = question.mesh;
  text += fmt::format("  available   {}\n", print_bit_rate(numbers.available));
  text += fmt::format("  limited by  {}\n", numbers.limited_by);
  text += fmt::format("  limit       {} of the medium's time, of which others take {}\n",
                      percent(mesh::limit_of(mesh)), percent(question.background));
  text += fmt::format("  packets     {} of payload, {} of header, {:g} us beside them\n",
                      many(mesh.packet_bytes, "byte"), many(mesh.header_bytes, "byte"),
                      static_cast<double>(mesh.packet_time) / 1e3);
  if (question.demand)
    text += fmt::format("  demand      {} takes {}: {}\n",
                        print_bit_rate(mul_saturating(*question.demand, kBitsPerByte)),
                        percent(numbers.demand_time), numbers.fits ? "fits" : "does not fit");
  return text;
}

double share_of_time(Value time) {
  return static_cast<double>(time) / static_cast<double>(mesh::kFullTime);
}

std::string to_json(const Question& question, const Numbers& numbers) {
  auto links = Json::array();
  for (const auto& link : question.graph.links)
    links.push_back({{"rate_bit_s", link.quality.rate},
                     {"loss", static_cast<double>(link.quality.loss) / kCertainLoss}});
  Json json = {{"path_rate_bit_s", numbers.paper},
               {"available_bit_s", numbers.available},
               {"limited_by", numbers.limited_by},
               {"limit", share_of_time(mesh::limit_of(question.mesh))},
               {"background", share_of_time(question.background)},
               {"packet_bytes", question.mesh.packet_bytes},
               {"header_bytes", question.mesh.header_bytes},
               {"overhead_us", static_cast<double>(question.mesh.packet_time) / 1e3},
               {"links", std::move(links)},
               {"demand", nullptr}};
  if (question.demand)
    json["demand"] = {{"rate_bit_s", mul_saturating(*question.demand, kBitsPerByte)},
                      {"medium_time", share_of_time(numbers.demand_time)},
                      {"fits", numbers.fits}};
  return json.dump() + "\n";
}

}  // namespace

Result<BandwidthAnswer> bandwidth(const BandwidthArguments& arguments) {
  const auto question = understand(arguments);
  if (!question) return std::unexpected(question.error());
  const auto numbers = evaluate(*question);
  return BandwidthAnswer{.text = to_text(*question, numbers),
                         .json = to_json(*question, numbers),
                         .fits = numbers.fits};
}

}  // namespace mlcca::tools
