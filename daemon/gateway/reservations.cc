// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/reservations.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "core/model/text.hpp"
#include "daemon/gateway/report.hpp"

namespace mlcca {
namespace {

/// Combines the reports of two channels on one medium: the longer response, the lower rates.
void worsen(control::MediumUse& sum, const control::MediumUse& use) {
  sum.response_ns = std::max(sum.response_ns, use.response_ns);
  sum.guaranteed_ns = std::max(sum.guaranteed_ns, use.guaranteed_ns);
  if (use.path.empty()) return;
  if (sum.path.empty() || use.path_rate < sum.path_rate) sum.path_rate = use.path_rate;
  if (sum.path.empty() || use.available < sum.available) {
    sum.available = use.available;
    sum.limited_by = use.limited_by;
  }
  if (use.path.size() > sum.path.size()) sum.path = use.path;
}

class Listing {
 public:
  Listing(const core::State& state, const LeaseOf& lease_of) : s_(state), lease_of_(lease_of) {}

  control::Reservations run(std::optional<core::Place> place) {
    for (std::size_t r = 0; r < system().resources(); ++r) {
      const core::Place here = place_of(r);
      if (!place || *place == here) add_place(here, r);
    }
    each_holding();
    std::erase_if(out_.resources, [](const control::Resource& r) {
      return r.kind == "gateway" && !r.capacity_known && r.reservations.empty();
    });
    return std::move(out_);
  }

 private:
  [[nodiscard]] const core::System& system() const { return s_.system(); }
  [[nodiscard]] core::Place place_of(std::size_t resource) const {
    const std::size_t networks = system().networks.size();
    return resource < networks ? core::Place{core::Place::Kind::network, resource}
                               : core::Place{core::Place::Kind::gateway, resource - networks};
  }

  control::Resource& add(std::string name, const char* kind, const char* unit) {
    control::Resource& r = out_.resources.emplace_back();
    r.name = std::move(name);
    r.kind = kind;
    r.unit = unit;
    return r;
  }

  void add_place(core::Place here, std::size_t resource) {
    const AttributeSet& provision = system().provision_of(here);
    const bool network = here.kind == core::Place::Kind::network;
    const std::string& name = core::name_of(system(), here);
    first_[resource] = out_.resources.size();
    control::Resource& r = add(name, network ? "network" : "gateway", "bytes/s");
    // A best case is not a capacity.
    r.capacity_known =
        provision.has(Attribute::bandwidth) && !provision.is_dynamic(Attribute::bandwidth);
    if (r.capacity_known) r.capacity = provision[Attribute::bandwidth];
    r.reserved = s_.ledger().reserved(resource);
    if (!network) return;
    if (const auto* bus = s_.ledger().schedule(here.index)) add_bus(name, *bus);
    if (const auto& view = s_.world().meshes[here.index]) add_domains(name, here.index, *view);
  }

  void add_bus(const std::string& name, const core::can::Schedule& bus) {
    control::Resource& r = add(name + ": bus time", "bus", "ppm");
    r.capacity_known = true;
    r.capacity = core::mesh::kWhole;
    r.background = bus.assumptions().background;
    const std::uint64_t all = bus.utilisation_ppm();
    r.reserved = all > r.background ? all - r.background : 0;
  }

  void add_domains(const std::string& name, std::size_t network, const core::MeshView& view) {
    for (std::size_t d = 0; d < view.domains().count(); ++d) {
      control::Resource& r = add(name + ": " + view.domain_name(d), "domain", "ps/s");
      r.capacity_known = true;
      r.capacity = core::mesh::limit_of(*system().networks[network].mesh);
      r.background = view.background[d];
      r.reserved = s_.ledger().medium_time(network, d);
    }
  }

  void each_holding() {
    for (std::size_t c = 0; c < system().channels.size(); ++c)
      for (const std::size_t p : s_.members().publishers_of(c))
        for (const core::Holding& h : s_.ledger().holdings_of(p))
          if (first_.contains(h.resource)) add_holding(c, p, h);
  }

  void add_holding(std::size_t channel, std::size_t publisher, const core::Holding& h) {
    control::Reservation r;
    r.channel = system().channels[channel].name;
    r.publisher = s_.members().publisher(publisher).name;
    r.admission = s_.members().admission_of_publisher(publisher);
    r.set = static_cast<std::uint32_t>(s_.decisions()[channel].set);
    r.importance = system().channels[channel].importance;
    if (r.admission != 0) r.lease_ns = lease_of_(r.admission);
    const std::size_t first = first_.at(h.resource);
    r.amount = h.bytes_per_second;
    out_.resources[first].reservations.push_back(r);
    if (h.scheduled) {
      const auto* message = s_.ledger()
                                .schedule(h.resource)
                                ->find(core::Ledger::key_of({publisher, h.resource, h.from}));
      r.amount = mul_div_up(message->transmission, core::mesh::kWhole, message->period);
      out_.resources[first + 1].reservations.push_back(r);
    }
    if (!h.mesh) return;
    for (const core::mesh::Share& share : h.mesh->shares) {
      r.amount = share.time;
      out_.resources[first + 1 + share.domain].reservations.push_back(r);
    }
  }

  const core::State& s_;
  const LeaseOf& lease_of_;
  control::Reservations out_;
  std::map<std::size_t, std::size_t> first_;  // index of the first entry of each resource
};

bool is_about_a_network(core::Obstacle obstacle) {
  using enum core::Obstacle;
  return obstacle == no_path || obstacle == no_rate || obstacle == links_absent ||
         obstacle == links_must_last || obstacle == relay_gated || obstacle == unavailable;
}

control::RouteReport new_route(const core::State& state, const core::Verdict& v, core::Place from) {
  control::RouteReport out;
  out.from = core::name_of(state.system(), from);
  out.to = core::name_of(state.system(), v.to);
  for (const core::Place p : v.route) out.route.push_back(core::name_of(state.system(), p));
  if (v.route.empty()) out.problem = "there is no way";
  return out;
}

/// Adds one more verdict that takes this route.
void count_in(const core::State& state, const core::Verdict& v, control::RouteReport& out) {
  ++(v.granted ? out.granted : out.refused);
  if (is_about_a_network(v.obstacle)) out.problem = why(state, v);
  for (const core::MediumUse& use : v.media) {
    const control::MediumUse now = medium_report(state, v, use, Own::is_taken);
    const auto same = std::ranges::find(out.media, now.network, &control::MediumUse::network);
    if (same == out.media.end())
      out.media.push_back(now);
    else
      worsen(*same, now);
  }
}

}  // namespace

control::Routes routes_report(const core::State& state) {
  control::Routes out;
  std::map<core::Route, std::size_t> known;
  for (const core::Decision& decision : state.decisions()) {
    for (const core::Verdict& v : decision.verdicts) {
      core::Route key = v.route;
      const core::Place from = state.members().publisher(v.publisher).place;
      if (key.empty()) key = {from, v.to};
      const auto [it, fresh] = known.try_emplace(key, out.routes.size());
      if (fresh) out.routes.push_back(new_route(state, v, from));
      count_in(state, v, out.routes[it->second]);
    }
  }
  return out;
}

void add_links(const core::mesh::Mesh& mesh, const core::mesh::LinkTable& table,
               const std::string& network, std::uint64_t now, control::Routes& out) {
  std::unordered_map<std::string_view, const std::string*> names;  // names of nodes, by address
  for (const core::mesh::Node& node : mesh.nodes) names.try_emplace(node.address, &node.name);
  const auto name = [&](const std::string& address) {
    const auto known = names.find(address);
    return known == names.end() ? address : *known->second;
  };
  for (const core::mesh::Known& known : table.links()) {
    control::MeshLink link;
    link.network = network;
    link.from = name(known.sample.from);
    link.to = name(known.sample.to);
    link.rate = known.sample.rate;
    link.believed_rate = known.believed_rate;
    link.kind = core::to_text(known.sample.kind);
    link.loss_known = known.sample.loss.has_value();
    link.loss = known.sample.loss.value_or(0);
    link.busy_known = known.sample.busy.has_value();
    link.busy = known.sample.busy.value_or(0);
    link.age_ns = now > known.sample.taken ? now - known.sample.taken : 0;
    link.stale = known.stale;
    if (known.stale)
      link.state = "stale";
    else if (known.believed_rate == 0)
      link.state = core::to_text(known.lack);
    link.source = core::name_of(mesh.sources[known.source]);
    out.links.push_back(std::move(link));
  }
  for (std::size_t s = 0; s < mesh.sources.size(); ++s)
    if (const std::string& problem = table.problem(s); !problem.empty())
      out.problems.push_back(
          fmt::format("{}: {}: {}", network, core::name_of(mesh.sources[s]), problem));
}

control::Reservations reservations_report(const core::State& state,
                                          std::optional<core::Place> place,
                                          const LeaseOf& lease_of) {
  return Listing(state, lease_of).run(place);
}

}  // namespace mlcca
