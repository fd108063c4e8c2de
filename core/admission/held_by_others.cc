// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/held_by_others.hpp"

#include <set>
#include <utility>

#include "core/admission/route_check.hpp"
#include "core/can/level.hpp"

namespace mlcca::core {
namespace {

/// Of what gateways hold of a mesh: what they have in the domains that the verdict needs.
std::vector<HeldBy> held_on_way(std::span<const HeldBy> held, const Verdict& v, std::size_t network,
                                const MeshView* view) {
  std::set<std::uint32_t> needed;
  for (const MediumUse& use : v.media)
    for (const auto& [from, to] : use.pairs)
      if (use.network == network && view != nullptr)
        for (const std::uint32_t link : view->path(from, to)) {
          const auto& here = view->domains().of_link(link);
          needed.insert(here.begin(), here.end());
        }
  std::vector<HeldBy> there;
  for (const HeldBy& one : held) {
    HeldBy part = one;
    std::erase_if(part.shares,
                  [&](const mesh::Share& share) { return !needed.contains(share.domain); });
    if (!part.shares.empty()) there.push_back(std::move(part));
  }
  return there;
}

}  // namespace

const std::vector<HeldBy>& HeldByOthers::of(std::size_t network) const {
  static const std::vector<HeldBy> nobody;
  if (holdings_ == nullptr || !world_.shared[network]) return nobody;
  const auto& view = world_.meshes[network];
  const auto known = known_.find(network);
  if (known != known_.end() && known->second.view == view) return known->second.by;
  Known held{view, held_by(system_, world_, network, holdings_->of_others(network))};
  const auto made_for = holdings_->made_for(network);
  for (HeldBy& one : held.by)
    if (const auto others = made_for.find(one.gateway); others != made_for.end())
      one.made_for = others->second;
  return known_.insert_or_assign(network, std::move(held)).first->second.by;
}

std::string HeldByOthers::objection_to(const Verdict& v) const {
  const bool is_left_to_others =
      v.obstacle == Obstacle::cluster || v.obstacle == Obstacle::disagreed;
  if (holdings_ == nullptr || !is_left_to_others) return {};
  std::vector<std::size_t> gateways;
  for (const Place place : v.route)
    if (place.kind == Place::Kind::gateway) gateways.push_back(place.index);
  return holdings_->objection(v.channel, gateways);
}

std::string HeldByOthers::excess(std::size_t network) const {
  // What is cheap to know comes first.
  const auto& view = world_.meshes[network];
  const AttributeSet& provision = system_.networks[network].provision;
  bool full = provision.has(Attribute::bandwidth) &&
              ledger_.reserved(network) > provision[Attribute::bandwidth];
  if (const can::Schedule* const bus = ledger_.schedule(network))
    full = full || bus->spares_any() || !bus->late().empty();
  for (std::size_t d = 0; !full && view && d < view->domains().count(); ++d)
    full = ledger_.medium_time(network, d) > mesh::limit_of(*system_.networks[network].mesh);
  return full ? excess_words(system_, world_, network, of(network)) : std::string();
}

/// Why it is not known what others hold.
std::string HeldByOthers::why_unknown(std::size_t network) const {
  if (const std::string words = holdings_->unreadable(network); !words.empty()) return ": " + words;
  const std::string words = uncountable_words(system_, of(network));
  return words.empty()
             ? words
             : ": reservations cannot be counted with the network as it is now, those of " + words;
}

std::string HeldByOthers::of_refusal(const Verdict& v) const {
  if (v.granted || holdings_ == nullptr) return {};
  std::vector<HeldBy> held;
  Place at = v.obstacle_at;
  if (v.obstacle == Obstacle::others_unknown) return why_unknown(at.index);
  if (v.obstacle == Obstacle::crowded) {
    held = of(at.index);
  } else if (const Row* const row = v.obstacle == Obstacle::none ? deciding_row(v) : nullptr;
             row != nullptr && row->place.kind == Place::Kind::network) {
    at = row->place;
    if (row->against == Against::capacity || row->against == Against::schedule)
      held = of(at.index);
    else if (row->against == Against::medium_time)
      held = held_on_way(of(at.index), v, at.index, world_.meshes[at.index].get());
  }
  const std::string words = holders_words(system_, at.index, held);
  return words.empty() ? words : "; reserved there by " + words;
}

}  // namespace mlcca::core
