// SPDX-License-Identifier: BSD-2-Clause
// Gateways that are called off because they are gone: of a proposed description, and of one that is
// coming into force.
#include <algorithm>
#include <string>
#include <vector>

#include "core/cluster/rollout.hpp"

namespace mlcca::core::cluster {
namespace {

constexpr const char* kNotWaitedFor =
    "it comes into force already, and waits for none of the gateways that are called off";

}  // namespace

bool Rollouts::is_among(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

std::string Rollouts::there(const std::string& name) {
  return name + ": it was called off, and is there";
}

bool Rollouts::is_gone(const View& view, std::size_t gateway, Value now) {
  const Alive alive = view.alive(gateway, now);
  return alive == Alive::absent || alive == Alive::fenced;
}

bool Rollouts::is_off(const View& view, std::size_t gateway, Value now, Work& work) {
  // If no description is in force, nobody has anything to leave.
  if (view.records().current.mod == 0) return true;
  if (!is_gone(view, gateway, now)) return false;
  work.compares.push_back(
      {.key = view.keys().member(gateway), .revision = view.records().members[gateway].mod});
  return true;
}

/// Whether the staged description is the one that is coming into force. Then it is not proposed:
/// all have agreed to it, and gateways are only called off.
bool Rollouts::calls_off(const Records& records) const {
  const auto& current = records.current.value;
  return staged_ && claimed_ == 0 && current && !current->open &&
         current->digest == staged_->digest;
}

/// Ends a calling off when nobody waits for these gateways any more, or if one of them is there.
void Rollouts::step_calling_off(const View& view, Value now, std::vector<Event>& events) {
  const auto& waits = view.records().current.value->waits;
  bool waited_for = false;
  for (const std::string& name : staged_->without) {
    if (!is_among(waits, name)) continue;
    waited_for = true;
    const auto gateway = view.keys().gateway(name);
    // The lease of one that is fenced ends soon.
    if (gateway && (view.is_fenced(*gateway) || is_gone(view, *gateway, now))) continue;
    give_up(there(name), events);
    return;
  }
  if (waited_for) return;
  if (has_called_off_)
    staged_.reset();
  else
    give_up(kNotWaitedFor, events);
}

/// Has nobody wait any more for the gateways that are called off. It fails if one of them has come
/// back since.
std::optional<Work> Rollouts::call_off(const View& view, const Codec& codec, Value now) const {
  if (!calls_off(view.records())) return std::nullopt;
  const auto& record = view.records().current;
  Current current = *record.value;
  Work work{.kind = Work::Kind::call_off,
            .stage = stage_,
            .compares = {{.key = view.keys().current(), .revision = record.mod}}};
  for (const std::string& name : staged_->without) {
    const auto gateway = view.keys().gateway(name);
    if (!is_among(current.waits, name)) continue;
    if (!gateway || !is_off(view, *gateway, now, work)) return std::nullopt;
    std::erase(current.waits, name);
  }
  work.puts.push_back({.key = view.keys().current(), .value = codec.write(current)});
  return work;
}

}  // namespace mlcca::core::cluster
