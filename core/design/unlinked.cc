// SPDX-License-Identifier: BSD-2-Clause
#include "core/design/unlinked.hpp"

#include <cstddef>

#include "core/admission/media.hpp"
#include "core/design/hints.hpp"
#include "core/model/text.hpp"

namespace mlcca::core {

UnlinkedMeshes::UnlinkedMeshes(const System& system) : system_(system) {
  for (std::size_t n = 0; n < system.networks.size(); ++n)
    if (!no_links_words(system.networks[n]).empty()) meshes_.insert(n);
}

void UnlinkedMeshes::add(const Situation& situation, const Verdict& verdict) {
  if (meshes_.empty()) return;
  const auto places = hops_of(verdict.route);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i].kind != Place::Kind::network || !meshes_.contains(places[i].index)) continue;
    visited_.insert(places[i].index);
    if (!stays_at_a_node(situation, verdict, i)) crossed_.insert(places[i].index);
  }
}

void UnlinkedMeshes::report(std::vector<Finding>& to) const {
  for (const std::size_t n : meshes_) {
    if (visited_.contains(n) && !crossed_.contains(n)) continue;
    Finding& f = to.emplace_back();
    f.id = FindingId::no_links;
    f.origin = system_.networks[n].mesh->origin;
    f.text = no_links_words(system_.networks[n]);
    f.hint = kNoLinksHint;
    f.place = {Place::Kind::network, n};
    f.has_place = true;
  }
}

}  // namespace mlcca::core
