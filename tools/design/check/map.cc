// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/check/map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <tuple>

#include "base/many.hpp"
#include "core/design/bus_responses.hpp"
#include "core/model/text.hpp"
#include "core/profiles/profile.hpp"
#include "tools/design/check/rows.hpp"

namespace mlcca::tools::design {
namespace {

using Json = nlohmann::ordered_json;
using core::Place;

bool is_best_case(const AttributeSet& provision, const core::UserValues& user) {
  bool dynamic = std::ranges::any_of(user, &core::UserValue::dynamic);
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const auto a = attribute_at(i);
    dynamic = dynamic || (provision.has(a) && provision.is_dynamic(a));
  }
  return dynamic;
}

/// The largest used part of a limit of a network (1 is all); nullopt if no limit is known. `on_bus`
/// is the load of an analysed bus.
std::optional<double> part_of(const core::Network& network, const core::NetworkLoad& load,
                              const std::optional<core::BusLoad>& on_bus) {
  std::optional<double> most;
  const auto take = [&](double part) { most = std::max(most.value_or(0.0), part); };
  const auto capacity = static_cast<double>(network.provision[Attribute::bandwidth]);
  if (network.provision.has(Attribute::bandwidth) && capacity > 0)
    take(static_cast<double>(load.reserved) / capacity);
  if (on_bus)
    take(static_cast<double>(on_bus->present) / core::mesh::kWhole);
  else if (load.time_ppm)
    take(static_cast<double>(*load.time_ppm) /
         (network.mesh ? std::max(network.mesh->limit, 1U) : core::mesh::kWhole));
  return most;
}

class Mapper {
 public:
  explicit Mapper(const SystemReport& report) : r_(report), s_(report.system) {
    for (const ReportedFinding& f : r_.findings)
      if (core::info(f.id).severity == core::Severity::error && !f.place.empty())
        ++errors_[f.place];
  }

  Map map() {
    Map out;
    out.json = {{"places", Json::array()}, {"ways", Json::array()}};
    for (std::size_t n = 0; n < s_.networks.size(); ++n) out.json["places"].push_back(network(n));
    for (const core::Gateway& g : s_.gateways) out.json["places"].push_back(gateway(g));
    std::vector<std::size_t> counts;
    for (const ReportedDelivery& d : r_.deliveries) {
      const auto [known, fresh] =
          ways_.try_emplace({d.route, d.from, d.to, d.outcome, d.refused_at}, ways_.size());
      if (fresh) {
        out.json["ways"].push_back(way(d));
        counts.push_back(0);
      }
      ++counts[known->second];
      out.way_of.push_back(known->second);
    }
    for (std::size_t i = 0; i < counts.size(); ++i) out.json["ways"][i]["many"] = counts[i];
    return out;
  }

 private:
  using Way = std::tuple<core::Route, Place, Place, Outcome, std::optional<Place>>;

  [[nodiscard]] std::size_t number_of(Place place) const { return s_.resource_of(place); }

  /// Puts the number of errors, such as "2 errors", before the other notes of a place.
  void add_errors(Json& place, const std::string& name, std::string note) const {
    const auto errors = errors_.find(name);
    place["ill"] = errors != errors_.end();
    if (errors != errors_.end())
      note = many(errors->second, "error") + (note.empty() ? "" : ", " + note);
    place["note"] = note;
  }

  [[nodiscard]] Json network(std::size_t n) const {
    const core::Network& network = s_.networks[n];
    Json out{{"label", network.name}, {"kind", core::to_text(network.kind)}};
    if (network.bus.bitrate != 0) out["bitrate"] = network.bus.bitrate;
    if (network.mesh && !network.mesh->links.empty()) {
      out["links"] = network.mesh->links.size();
      out["slowest"] =
          std::ranges::min(network.mesh->links, {}, &core::mesh::DescribedLink::rate).rate;
    }
    if (network.provision.has(Attribute::bandwidth))
      out["capacity"] = network.provision[Attribute::bandwidth];
    std::string note =
        core::names_channels(network.profile) ? std::string(core::to_text(network.profile)) : "";
    if (is_best_case(network.provision, network.user))
      note += note.empty() ? "best cases only" : ", best cases only";
    add_errors(out, network.name, note);
    if (n < r_.inspection.networks.size())
      if (const auto part = part_of(network, r_.inspection.networks[n], core::load_on(r_.buses, n)))
        out["load"] = *part;
    return out;
  }

  [[nodiscard]] Json gateway(const core::Gateway& gateway) const {
    Json out{{"label", gateway.name}, {"next", Json::array()}};
    for (const core::Port& port : gateway.ports) out["next"].push_back(port.network);
    add_errors(out, gateway.name,
               is_best_case(gateway.provision, gateway.user) ? "best cases only" : "");
    return out;
  }

  [[nodiscard]] Json way(const ReportedDelivery& d) const {
    Json out{{"from", number_of(d.from)},
             {"to", number_of(d.to)},
             {"outcome", said(d.outcome).kind},
             {"route", Json::array()}};
    for (const Place place : d.route) out["route"].push_back(number_of(place));
    if (d.refused_at) out["stop"] = number_of(*d.refused_at);
    return out;
  }

  const SystemReport& r_;
  const core::System& s_;
  std::map<std::string, std::size_t> errors_;  ///< number of errors by name of the place
  std::map<Way, std::size_t> ways_;
};

}  // namespace

Map map_of(const SystemReport& report) { return Mapper(report).map(); }

}  // namespace mlcca::tools::design
