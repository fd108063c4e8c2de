// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/generate/unit.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <utility>

#include "core/model/text.hpp"
#include "tools/design/generate/names.hpp"

namespace mlcca::tools::design {
namespace {

template <class Visit>
auto with_end(const core::System& system, End end, Visit visit) {
  return end.role == der::Role::publisher ? visit(system.publishers[end.index])
                                          : visit(system.subscribers[end.index]);
}

class Collector {
 public:
  explicit Collector(const core::System& system) : system_(system) {}

  std::vector<Unit> units() {
    for (const auto& component : system_.components)
      units_.push_back({.name = component.name,
                        .stem = {},
                        .scope = {},
                        .about = "component",
                        .place = component.place,
                        .ends = {}});
    for (std::size_t i = 0; i < system_.publishers.size(); ++i)
      add({der::Role::publisher, i}, system_.publishers[i]);
    for (std::size_t i = 0; i < system_.subscribers.size(); ++i)
      add({der::Role::subscriber, i}, system_.subscribers[i]);
    std::erase_if(units_, [](const Unit& unit) { return unit.ends.empty(); });
    Names stems;
    Names scopes;
    for (auto& unit : units_) {
      unit.stem = stems.take(file_name(unit.name));
      unit.scope = scopes.take(small_name(unit.name));
    }
    return std::move(units_);
  }

 private:
  template <class Described>
  void add(End end, const Described& described) {
    auto at = static_cast<std::size_t>(described.component);
    if (described.component == core::kNoComponent) at = of_place(described.place);
    units_[at].ends.push_back(end);
  }

  std::size_t of_place(core::Place place) {
    const auto [it, fresh] = of_place_.try_emplace(place, units_.size());
    if (fresh) {
      const bool network = place.kind == core::Place::Kind::network;
      units_.push_back({.name = core::name_of(system_, place),
                        .stem = {},
                        .scope = {},
                        .about = network ? "what sits on the network" : "what runs on the gateway",
                        .place = place,
                        .ends = {}});
    }
    return it->second;
  }

  const core::System& system_;
  std::vector<Unit> units_;
  std::map<core::Place, std::size_t> of_place_;
};

}  // namespace

const std::string& name_of(const core::System& system, End end) {
  return end.role == der::Role::publisher ? system.publishers[end.index].name
                                          : system.subscribers[end.index].name;
}

std::size_t channel_of(const core::System& system, End end) {
  return with_end(system, end, [](const auto& e) { return e.channel; });
}

core::Place place_of(const core::System& system, End end) {
  return with_end(system, end, [](const auto& e) { return e.place; });
}

std::vector<EndSet> sets_of(const core::System& system, End end) {
  return with_end(system, end, [&](const auto& e) {
    std::vector<EndSet> out = {{system.channels[e.channel].priority, &e.attributes, &e.user}};
    for (const auto& lower : e.lower)
      out.push_back({lower.priority, &lower.attributes, &lower.user});
    return out;
  });
}

std::string set_suffix(const std::vector<EndSet>& sets, std::size_t i) {
  if (i == 0) return {};
  const int priority = sets[i].priority;
  return fmt::format("Priority{}{}", priority < 0 ? "Minus" : "",
                     priority < 0 ? -priority : priority);
}

Result<std::vector<Unit>> units_of(const core::System& system,
                                   const std::vector<std::string>& only) {
  auto units = Collector(system).units();
  std::vector<std::string> known;
  known.reserve(units.size());
  for (const auto& unit : units) known.push_back(unit.name);
  for (const auto& name : only) {
    if (std::ranges::find(known, name) != known.end()) continue;
    const bool idle = std::ranges::find(system.components, name, &core::Component::name) !=
                      system.components.end();
    return fail(
        idle ? fmt::format("component {} publishes and subscribes nothing", name)
             : fmt::format("there is no component {}; there are {}", name, fmt::join(known, ", ")));
  }
  if (!only.empty())
    std::erase_if(
        units, [&](const Unit& unit) { return std::ranges::find(only, unit.name) == only.end(); });
  return units;
}

}  // namespace mlcca::tools::design
