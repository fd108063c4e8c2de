// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/learn_described.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <set>

#include "core/design/inspect.hpp"
#include "core/model/words.hpp"
#include "core/profiles/profile.hpp"
#include "description/read.hpp"
#include "tools/design/learn_deadlines.hpp"

namespace mlcca::tools::design {
namespace {

const core::Network* network_at(const core::System& system, const std::string& interface,
                                const std::map<std::string, std::string>& networks) {
  const auto name = networks.find(interface);
  if (name == networks.end()) return nullptr;
  const auto found = std::ranges::find(system.networks, name->second, &core::Network::name);
  return found == system.networks.end() ? nullptr : &*found;
}

bool is_on(const learn::DraftChannel& row, const std::string& interface) {
  return row.interface == interface || row.numbers.contains(interface);
}

std::vector<core::Finding> errors_of(core::System& system) {
  system.sort_bindings();
  std::vector<core::Finding> out = core::inspect(system).findings;
  std::erase_if(out, [](const core::Finding& finding) {
    return core::info(finding.id).severity != core::Severity::error;
  });
  return out;
}

}  // namespace

std::map<std::string, core::Profile> described_profiles(
    const core::System& system, const std::map<std::string, std::string>& networks) {
  std::map<std::string, core::Profile> out;
  for (const auto& [interface, name] : networks)
    if (const auto* const network = network_at(system, interface, networks);
        network != nullptr && core::names_channels(network->profile))
      out.emplace(interface, network->profile);
  return out;
}

std::vector<std::string> leave_out_others(const core::System& system,
                                          const learn::Observer& observer,
                                          const std::vector<std::string>& names,
                                          const std::map<std::string, std::string>& networks,
                                          learn::Draft& draft) {
  std::vector<std::string> notes;
  std::set<std::string> others;
  for (std::uint32_t i = 0; i < names.size(); ++i) {
    const auto* const network = network_at(system, names[i], networks);
    const auto& of = observer.interfaces()[i];
    if (network == nullptr || of.frames == 0) continue;
    const bool is_can = network->kind == core::NetworkKind::can;
    const bool has_can = of.medium == learn::Medium::can;
    if (is_can == has_can && network->profile == of.recognised->profile) continue;
    if (std::ranges::none_of(draft.channels, [&](const auto& row) { return is_on(row, names[i]); }))
      continue;
    others.insert(names[i]);
    notes.push_back(fmt::format(
        "{}: nothing is proposed for the network {}, which has {}: the traffic is that of {} with "
        "the profile {}",
        names[i], network->name,
        core::names_channels(network->profile)
            ? fmt::format("the profile {}", core::words::kProfiles.of(network->profile))
            : "no profile",
        has_can ? "CAN" : "Ethernet", core::words::kProfiles.of(of.recognised->profile)));
  }
  std::erase_if(draft.channels, [&](const learn::DraftChannel& row) {
    return std::ranges::any_of(others, [&](const auto& name) { return is_on(row, name); });
  });
  return notes;
}

std::vector<std::string> refused_when_patched(
    core::System system, const std::vector<std::pair<std::string, std::string>>& files) {
  if (files.empty() || system.files.empty()) return {};
  const std::string& path = system.files.front();
  if (files.size() > 1 || files.front().first != path)
    return {"the patch changes files that " + path +
            " includes: run 'mlccactl check' when it is applied"};
  const std::string folder = std::filesystem::absolute(path).parent_path().string();
  auto patched =
      description::read_memory(files.front().second, path, folder, description::Users::any);
  if (!patched) {
    std::vector<std::string> notes;
    for (const description::Problem& problem : patched.error())
      notes.push_back("the patched description has mistakes: " + description::to_string(problem));
    if (notes.size() > 1) notes.resize(1);
    return notes;
  }
  std::set<std::string> before;
  for (const core::Finding& finding : errors_of(system)) before.insert(finding.text);
  auto refused = errors_of(*patched);
  std::erase_if(refused,
                [&](const core::Finding& finding) { return before.contains(finding.text); });
  return notes_on(refused, "the patched description");
}

}  // namespace mlcca::tools::design
