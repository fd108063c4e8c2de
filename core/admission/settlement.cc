// SPDX-License-Identifier: BSD-2-Clause
// What a round of changes touches, and what becomes of it.
#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "core/admission/allocation.hpp"
#include "core/admission/sharing.hpp"
#include "core/admission/state.hpp"
#include "core/model/progress.hpp"

namespace mlcca::core {
namespace {

/// Domains depend on which links there are, also those that carry nothing now, and not on how good
/// they are.
bool same_topology(const mesh::Graph& a, const mesh::Graph& b) {
  const auto same_ends = [](const auto& x, const auto& y) {
    return x.from == y.from && x.to == y.to;
  };
  return a.nodes == b.nodes &&
         std::ranges::equal(a.links, b.links,
                            [&](const auto& x, const auto& y) {
                              return same_ends(x, y) && x.channel == y.channel;
                            }) &&
         std::ranges::equal(a.unusable, b.unusable, same_ends);
}

}  // namespace

/// One round of changes: finds what they touch, brings ledger and world in line, and decides.
class State::Settlement {
 public:
  explicit Settlement(State& state) : s_(state) {}

  std::vector<DecisionChange> run() {
    collect();
    Allocation allocation(s_.situation(), s_.ages_, s_.decisions_, s_.ledger_, &before_);
    for (const std::size_t c : s_.touched_) allocation.take_out(c);
    s_.ledger_.commit();
    renew_world();
    std::vector<std::vector<std::size_t>> short_of;
    std::vector<std::size_t> touched(s_.touched_.begin(), s_.touched_.end());
    allocation.sort(touched);
    // Mostly all channels can be kept, and then it need not be found out which of them share
    // something.
    if (!allocation.keep(touched)) {
      for (Component& component : components()) {
        allocation.sort(component.touched);
        if (!allocation.keep(component.touched))
          short_of.emplace_back(component.sharing.begin(), component.sharing.end());
      }
    }
    for (std::vector<std::size_t>& channels : short_of) {
      for (const std::size_t c : channels) allocation.take_out(c);
      relax(channels);
      allocation.sort(channels);
      allocation.degrade(channels);
    }
    s_.ledger_.commit();
    hand_out(allocation);
    s_.ledger_.place_rest();
    s_.touched_.clear();
    s_.relieved_.clear();
    Progress::made();
    return changes();
  }

 private:
  /// Channels that share something, directly or over others. What one of them gives up or takes
  /// matters to no channel outside.
  struct Component {
    std::vector<std::size_t> touched;
    std::set<std::size_t> sharing;
  };
  /// What several channels want: a resource, or a domain of one that is a mesh.
  using Shared = std::pair<std::size_t, std::size_t>;
  static constexpr std::size_t kAllOfIt = ~std::size_t{0};

  struct NewView {
    std::size_t network = 0;
    std::shared_ptr<MeshView> view;  ///< nothing is known
    bool same_domains = false;
  };

  std::vector<Component> components() {
    std::vector<Component> all;
    std::set<std::size_t> placed;
    for (const std::size_t c : s_.touched_) {
      Progress::step();
      if (s_.decisions_[c].granted == 0 || placed.contains(c)) continue;
      Component component;
      component.sharing = sharing_with(
          c, [this](std::size_t channel) { return shared_by(channel); },
          [this](const Shared& shared) { return users_of(shared); });
      for (const std::size_t other : component.sharing) {
        Progress::step();
        if (!s_.touched_.contains(other) || s_.decisions_[other].granted == 0) continue;
        component.touched.push_back(other);
        placed.insert(other);
      }
      all.push_back(std::move(component));
    }
    return all;
  }

  [[nodiscard]] std::set<Shared> shared_by(std::size_t channel) const {
    std::set<Shared> all;
    for (const std::size_t r : s_.usage_.resources_of(channel))
      if (is_shared(r)) all.emplace(r, kAllOfIt);
    for (const auto& [network, key] : s_.usage_.pairs_of_channel(channel))
      for (const std::uint32_t d : domains_of(network, key)) all.emplace(network, d);
    return all;
  }

  /// There is only so much of it for all that it carries.
  [[nodiscard]] bool is_shared(std::size_t resource) const {
    const std::size_t networks = s_.system_.networks.size();
    const bool network = resource < networks;
    if (network && s_.ledger_.schedule(resource) != nullptr) return true;
    const AttributeSet& provision = network ? s_.system_.networks[resource].provision
                                            : s_.system_.gateways[resource - networks].provision;
    return provision.has(Attribute::bandwidth);
  }

  /// On the way between two nodes, as the links are now.
  [[nodiscard]] std::set<std::uint32_t> domains_of(std::size_t network, std::uint64_t key) const {
    std::set<std::uint32_t> all;
    const auto& view = s_.world_.meshes[network];
    if (!view) return all;
    const auto [from, to] = Usage::pair_of(key);
    for (const std::uint32_t link : view->path(from, to)) {
      const auto& here = view->domains().of_link(link);
      all.insert(here.begin(), here.end());
    }
    return all;
  }

  std::vector<std::size_t> users_of(const Shared& shared) {
    const auto [resource, domain] = shared;
    if (domain == kAllOfIt) {
      const auto& carried = s_.usage_.carried_by(resource);
      return {carried.begin(), carried.end()};
    }
    auto [it, fresh] = domain_users_.try_emplace(resource);
    if (fresh)
      for (const auto& [key, channels] : s_.usage_.pairs_of(resource)) {
        Progress::made();
        for (const std::uint32_t d : domains_of(resource, key))
          it->second[d].insert(it->second[d].end(), channels.begin(), channels.end());
      }
    return it->second[domain];
  }

  /// Admits waiting channels and upgrades until what became free is given away, and what that sets
  /// free.
  void hand_out(Allocation& allocation) {
    for (;;) {
      find_relief();
      std::vector<std::size_t> waiting = waiting_channels();
      allocation.sort(waiting);
      bool any = false;
      while (allocation.admit_waiting(waiting) || allocation.upgrade(waiting)) any = true;
      if (!any) return;
    }
  }

  void touch(const Usage::Channels& channels) {
    for (const std::size_t c : channels) {
      s_.touched_.insert(s_.touched_.end(), c);
      Progress::step();
    }
  }

  void collect() {
    invalidate_shared_background();
    for (const auto& [network, condition] : s_.new_.conditions) {
      touch(s_.usage_.carried_by(network));
      s_.relieved_.insert(network);
    }
    for (auto& [network, links] : s_.new_.graphs) collect_mesh(network, std::move(links));
    s_.new_.graphs.clear();
    for (const auto& [gateway, failed] : s_.new_.failed) {
      s_.world_.failed[gateway] = failed;
      collect_ways_over(gateway);
    }
    if (!s_.new_.failed.empty() && s_.permits_ != nullptr)
      for (std::size_t n = 0; n < s_.system_.networks.size(); ++n)
        if (s_.world_.shared[n]) s_.others_stale_.insert(n);
    s_.new_.failed.clear();
    collect_others();
  }

  /// What others hold of a network is taken in beside what is held here, if that can be kept. Else
  /// all that the network carries is decided again.
  void collect_others() {
    s_.note_permits();
    for (const NewView& now : views_)
      if (s_.has_others(now.network)) s_.others_stale_.insert(now.network);
    for (const auto& [network, condition] : s_.new_.conditions)
      if (s_.has_others(network)) rebuilt_.insert(network);
    for (const std::size_t n : std::exchange(s_.others_stale_, {})) {
      const auto view = std::ranges::find(views_, n, &NewView::network);
      const bool same = view == views_.end() || view->same_domains;
      if (rebuilt_.contains(n) || !same) {
        rebuilt_.insert(n);
        continue;
      }
      const MeshView* const links =
          view == views_.end() ? s_.world_.meshes[n].get() : view->view.get();
      const Ledger::Change change = s_.ledger_.set_others(n, others_on(n, links));
      if (!change.fits) {
        rebuilt_.insert(n);
        touch(s_.usage_.carried_by(n));
      }
      if (change.relieved || !change.fits) s_.relieved_.insert(n);
      if (change.held) s_.touch_detours(n);
    }
  }

  [[nodiscard]] Others others_on(std::size_t network, const MeshView* view) {
    Others others = s_.others_on(network, view);
    s_.others_complete_.resize(s_.system_.networks.size(), true);
    s_.others_complete_[network] = others.complete;
    return others;
  }

  /// What the description promises them, or what they have reserved, gives way while it is shared
  /// out.
  void relax(const std::vector<std::size_t>& channels) {
    if (s_.permits_ == nullptr) return;
    s_.ledger_.commit();
    for (const std::size_t c : channels)
      for (const std::size_t p : s_.members_.publishers_of(c)) s_.ledger_.relax(p);
  }

  /// Channels that have a way over the gateway and another one.
  void collect_ways_over(std::size_t gateway) {
    const Place place{Place::Kind::gateway, gateway};
    for (std::size_t c = 0; c < s_.decisions_.size(); ++c) {
      Progress::step();
      if (std::ranges::any_of(s_.decisions_[c].verdicts, [&](const Verdict& v) {
            const auto& routes =
                s_.topology_.routes(s_.members_.publisher(v.publisher).place, v.to);
            return routes.size() > 1 && std::ranges::any_of(routes, [&](const Route& route) {
                     return std::ranges::find(route, place) != route.end();
                   });
          }))
        s_.touched_.insert(c);
    }
  }

  /// Where load of an unadmitted sender is observed, the background depends on which channels are
  /// analysed: a change of one of them concerns all.
  void invalidate_shared_background() {
    for (std::size_t n = 0; n < s_.world_.conditions.size(); ++n) {
      if (s_.world_.conditions[n].observed.empty() || s_.new_.conditions.contains(n)) continue;
      const auto& here = s_.usage_.carried_by(n);
      if (std::ranges::any_of(s_.touched_, [&](std::size_t c) {
            Progress::step();
            return here.contains(c);
          }))
        s_.new_.conditions.emplace(n, s_.world_.conditions[n]);
    }
  }

  void collect_mesh(std::size_t network, NewGraph links) {
    const auto& old = s_.world_.meshes[network];
    auto& graph = links.graph;
    if (graph && old && *graph == old->graph) return;
    std::shared_ptr<MeshView> now;
    const bool same = old && graph && same_topology(old->graph, *graph);
    if (graph) {
      now = std::make_shared<MeshView>(*s_.system_.networks[network].mesh, std::move(*graph),
                                       std::move(links.addresses), same ? old.get() : nullptr);
      if (same) {
        collect_pairs(network, *old, *now);
      } else {
        touch(s_.usage_.carried_by(network));
        s_.relieved_.insert(network);
      }
      take_background(*now);
    } else {
      touch(s_.usage_.carried_by(network));
    }
    views_.push_back({network, std::move(now), same});
  }

  /// Only flows over a pair of nodes whose path or whose links are others than before.
  void collect_pairs(std::size_t network, const MeshView& old, const MeshView& now) {
    const auto changed = [&](std::uint32_t link) {
      const mesh::Link& a = old.graph.links[link];
      const mesh::Link& b = now.graph.links[link];
      return a.quality != b.quality || a.busy != b.busy;
    };
    std::vector<bool> domain_changed(now.domains().count(), false);
    for (std::uint32_t l = 0; l < now.graph.links.size(); ++l)
      if (old.graph.links[l].busy != now.graph.links[l].busy)
        for (const std::uint32_t d : now.domains().of_link(l)) domain_changed[d] = true;
    const auto in_changed_domain = [&](std::uint32_t link) {
      return std::ranges::any_of(now.domains().of_link(link),
                                 [&](std::uint32_t d) { return domain_changed[d]; });
    };
    for (const auto& [key, channels] : s_.usage_.pairs_of(network)) {
      Progress::made();
      const auto [from, to] = Usage::pair_of(key);
      const auto& path = now.path(from, to);
      if (path != old.path(from, to) || std::ranges::any_of(path, changed) ||
          std::ranges::any_of(path, in_changed_domain))
        touch(channels);
    }
    // Also where links got worse only: packets may take another way through the mesh.
    s_.relieved_.insert(network);
  }

  /// Others take what is measured: a source that can distinguish our own traffic has subtracted it.
  /// Nothing is taken off for what is reserved here, since it is unknown whether it was sent.
  static void take_background(MeshView& view) {
    for (std::size_t d = 0; d < view.domains().count(); ++d)
      view.background[d] = view.domains().busy_of(d);
  }

  /// No channel that is touched holds anything any more.
  void renew_world() {
    for (auto& [network, condition] : s_.new_.conditions) {
      s_.world_.conditions[network] = std::move(condition);
      s_.ledger_.set_bus(network, bus_of(s_.system_, s_.world_.conditions[network], network));
      Progress::made();
    }
    s_.new_.conditions.clear();
    for (auto& [network, view, same_domains] : views_) {
      if (!same_domains) s_.ledger_.set_domains(network, view ? view->domains().count() : 0);
      s_.world_.meshes[network] = std::move(view);
    }
    for (const std::size_t n : rebuilt_)
      s_.ledger_.rebuild_others(n, others_on(n, s_.world_.meshes[n].get()));
  }

  /// Networks that carry less of a channel than before, or something else.
  void find_relief() {
    for (const auto& [channel, old] : before_) {
      Progress::step();
      const Decision& now = s_.decisions_[channel];
      // Who was touched may hold something else now, also where it was granted the same.
      if (old.granted == 0 || (!s_.touched_.contains(channel) && is_same(old, now))) continue;
      for (const std::size_t r : s_.usage_.resources_of(channel)) s_.relieved_.insert(r);
    }
  }

  [[nodiscard]] static bool is_same(const Decision& a, const Decision& b) {
    return a.set == b.set && a.granted == b.granted &&
           std::ranges::equal(a.verdicts, b.verdicts, [](const Verdict& x, const Verdict& y) {
             return x.granted == y.granted && x.publisher == y.publisher && x.to == y.to &&
                    x.route == y.route;
           });
  }

  [[nodiscard]] std::vector<std::size_t> waiting_channels() const {
    std::set<std::size_t> waiting;
    const auto add = [&waiting](std::size_t channel) {
      waiting.insert(channel);
      Progress::step();
    };
    for (const std::size_t c : s_.touched_) add(c);
    for (const auto& [channel, before] : before_) add(channel);
    for (const std::size_t r : s_.relieved_)
      for (const std::size_t c : s_.usage_.waiting_for(r)) add(c);
    return {waiting.begin(), waiting.end()};
  }

  std::vector<DecisionChange> changes() {
    std::vector<DecisionChange> all;
    for (auto& [channel, before] : before_) {
      s_.usage_.set(s_.situation(), channel, s_.decisions_[channel]);
      all.push_back({channel, std::move(before)});
      Progress::step();
    }
    return all;
  }

  State& s_;
  Allocation::Former before_;
  std::vector<NewView> views_;
  std::set<std::size_t> rebuilt_;  ///< networks of which others hold something else now
  /// Of each mesh that was asked for: the channels over each of its domains.
  std::map<std::size_t, std::map<std::size_t, std::vector<std::size_t>>> domain_users_;
};

std::vector<DecisionChange> settle_news(State& state) { return State::Settlement(state).run(); }

}  // namespace mlcca::core
