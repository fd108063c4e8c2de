// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/import/network.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/profiles/profile.hpp"

namespace mlcca::tools::design {

bool is_bindable(ImportedNetwork& network, const ImportedMessage& message) {
  constexpr Value frame = 8;
  constexpr std::uint8_t everybody = 0xff;
  core::Binding binding;
  binding.id = message.id;
  binding.extended = message.extended;
  binding.format = message.format;
  binding.priority = message.priority;
  binding.destination = message.destination;
  auto problems = core::traits_of(network.profile).problems(binding);
  if (message.destination.value_or(everybody) != everybody &&
      message.attributes[Attribute::max_payload] > frame)
    problems.emplace_back(
        "more than 8 bytes to one address need a connection, which no gate passes");
  for (const auto& problem : problems)
    network.lacks.add("no-binding", "cannot be bound on such a network: left out", message.line,
                      fmt::format("{}: {}", message.name, problem));
  return problems.empty();
}

void merge(ImportedNetwork& into, ImportedNetwork from) {
  const auto first = into.nodes.size();
  for (auto& message : from.messages) {
    for (auto& sender : message.senders) sender.node += first;
    for (auto& receiver : message.receivers) receiver += first;
    const auto same = std::ranges::find_if(into.messages, [&](const ImportedMessage& other) {
      return other.id == message.id && other.extended == message.extended;
    });
    if (same == into.messages.end()) {
      into.messages.push_back(std::move(message));
      continue;
    }
    if (!same->senders.empty() && !message.senders.empty()) {
      into.lacks.add("repeated", "another message has the identifier: left out", message.line,
                     fmt::format("{} of {}", message.name, from.file));
      continue;
    }
    // Who sends it knows what it is.
    if (same->senders.empty()) std::swap(*same, message);
    for (const auto receiver : message.receivers)
      if (std::ranges::find(same->receivers, receiver) == same->receivers.end())
        same->receivers.push_back(receiver);
  }
  into.nodes.insert(into.nodes.end(), std::make_move_iterator(from.nodes.begin()),
                    std::make_move_iterator(from.nodes.end()));
  for (const auto& lack : from.lacks.all()) into.lacks.add(lack, from.file);
  into.file += ", " + from.file;
}

void name_senders(ImportedNetwork& network) {
  // There nobody can say what number it would have.
  if (core::has_nodes(network.profile)) return;
  std::optional<std::size_t> unnamed;
  for (auto& message : network.messages) {
    if (!message.senders.empty()) continue;
    if (!unnamed) {
      unnamed = network.nodes.size();
      network.nodes.push_back({"unnamed-sender", "senders that no file names", {}});
    }
    message.senders.push_back({*unnamed, std::nullopt});
    message.remark = "Assumed: no file says who sends this, nor how often.";
    network.lacks.add("no-sender", "no sender is named: published by unnamed-sender", message.line,
                      message.name);
  }
}

}  // namespace mlcca::tools::design
