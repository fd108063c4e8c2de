// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/import/network.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "core/profiles/profile.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::string_view kUnnamedSender = "unnamed-sender";

/// Whether several nodes may send the same message.
bool may_have_senders(const ImportedNetwork& network) {
  return network.kind == core::NetworkKind::other || core::has_nodes(network.profile);
}

/// Converts an end of a message with the attributes `before` into one of a message with `now`: it
/// keeps what it had from its message.
ImportedEnd with_own(ImportedEnd end, const AttributeSet& before, const AttributeSet& now) {
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const auto a = attribute_at(i);
    if (!end.attributes.has(a) && before.has(a) && (!now.has(a) || now[a] != before[a]))
      end.attributes.set(a, before[a]);
  }
  return end;
}

/// Removes attributes that the end has from the message anyway.
void drop_same(ImportedEnd& end, const AttributeSet& message) {
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const auto a = attribute_at(i);
    if (end.attributes.has(a) && message.has(a) && end.attributes[a] == message[a])
      end.attributes.clear(a);
  }
}

/// Adds the nodes of `from` to `into` and returns their indices there. Nodes with the same number,
/// or without numbers the same name, are one node.
std::vector<std::size_t> join_nodes(ImportedNetwork& into, const ImportedNetwork& from) {
  const bool by_name = into.kind == core::NetworkKind::other;
  using Key = std::pair<std::optional<std::uint8_t>, std::string>;
  const auto key_of = [](const ImportedNode& node) {
    return node.number ? Key{node.number, ""} : Key{std::nullopt, node.name};
  };
  std::map<Key, std::size_t> known;
  for (std::size_t i = 0; i < into.nodes.size(); ++i) known.emplace(key_of(into.nodes[i]), i);
  std::vector<std::size_t> places;
  places.reserve(from.nodes.size());
  for (const auto& node : from.nodes) {
    const auto same = known.find(key_of(node));
    const bool joined = same != known.end() && (node.number || by_name);
    places.push_back(joined ? same->second : into.nodes.size());
    if (!joined) into.nodes.push_back(node);
  }
  return places;
}

void assume_bit_rates(ImportedNetwork& network) {
  if (network.kind != core::NetworkKind::can) return;
  if (network.bitrate == 0) {
    network.bitrate = kAssumedBitrate;
    network.lacks.add("bit-rate", "is not stated (--bitrate)", 0, "500 kbit/s are assumed");
  }
  const bool has_fd = std::ranges::any_of(network.messages, [](const ImportedMessage& m) {
    return m.format != core::FrameFormat::classic;
  });
  if (!has_fd) {
    network.data_bitrate = 0;
  } else if (network.data_bitrate < network.bitrate) {
    network.data_bitrate = std::max(kAssumedDataBitrate, network.bitrate);
    network.lacks.add("data-bit-rate", "of FD frames is not stated (--data-bitrate)", 0,
                      "2 Mbit/s are assumed");
  }
}

void name_senders(ImportedNetwork& network) {
  std::optional<std::size_t> unnamed;
  for (auto& message : network.messages) {
    if (!message.senders.empty()) continue;
    // On such a network it cannot be known what number an added publisher would have.
    if (network.kind == core::NetworkKind::can && core::has_nodes(network.profile)) {
      if (network.is_part)
        add_lack(network, "no-sender", "no file has the node that publishes it: add a Publisher",
                 message, message.name);
      continue;
    }
    if (!unnamed) {
      unnamed = network.nodes.size();
      network.nodes.push_back({std::string(kUnnamedSender), "senders that no file names", {}});
    }
    message.senders.push_back({*unnamed, std::nullopt, {}});
    message.arrival = core::Arrival::sporadic;
    message.remark = "Assumed: no file says who sends this, nor how often.";
    add_lack(network, "no-sender", "no sender is named: sporadic, published by unnamed-sender",
             message, message.name);
  }
}

/// Adds the file's name to everything that comes from it.
void name_file(ImportedNetwork& network) {
  if (network.is_merged) return;
  network.is_merged = true;
  for (auto& message : network.messages) message.file = network.file;
  Lacks named;
  for (const auto& lack : network.lacks.all()) named.add(lack, network.file);
  network.lacks = std::move(named);
}

}  // namespace

void add_lack(ImportedNetwork& network, std::string_view kind, std::string_view what,
              const ImportedMessage& message, const std::string& item) {
  if (message.file.empty() || message.line == 0)
    network.lacks.add(kind, what, message.line, item);
  else
    network.lacks.add(kind, what, 0, fmt::format("{}:{}: {}", message.file, message.line, item));
}

bool is_bindable(ImportedNetwork& network, const ImportedMessage& message) {
  constexpr Value frame = 8;
  constexpr std::uint8_t global_address = 0xff;
  core::Binding binding;
  binding.id = message.id;
  binding.extended = message.extended;
  binding.format = message.format;
  binding.priority = message.priority;
  binding.destination = message.destination;
  auto problems = core::traits_of(network.profile).problems(binding);
  if (message.destination.value_or(global_address) != global_address &&
      message.attributes[Attribute::max_payload] > frame)
    problems.emplace_back(
        "more than 8 bytes to one address need a connection, which no gate passes");
  for (const auto& problem : problems)
    network.lacks.add("no-binding", "cannot be bound on such a network: left out", message.line,
                      fmt::format("{}: {}", message.name, problem));
  return problems.empty();
}

std::vector<ImportedEnd> receivers_of(const std::vector<std::size_t>& nodes) {
  std::vector<ImportedEnd> out;
  out.reserve(nodes.size());
  for (const auto node : nodes) out.push_back({.node = node, .number = {}, .attributes = {}});
  return out;
}

void remove_receiver(ImportedMessage& message, std::size_t node) {
  std::erase_if(message.receivers, [&](const ImportedEnd& end) { return end.node == node; });
}

void add_receiver(ImportedMessage& message, const ImportedEnd& end) {
  const auto there = std::ranges::find(message.receivers, end.node, &ImportedEnd::node);
  if (there == message.receivers.end()) {
    message.receivers.push_back(end);
    return;
  }
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const auto a = attribute_at(i);
    if (end.attributes.has(a) &&
        (!there->attributes.has(a) || end.attributes[a] < there->attributes[a]))
      there->attributes.set(a, end.attributes[a]);
  }
}

Joiner::Joiner(ImportedNetwork& network) : network_(network) {
  for (std::size_t i = 0; i < network.messages.size(); ++i)
    known_.emplace(identity_of(network.messages[i]), i);
}

Joiner::Identity Joiner::identity_of(const ImportedMessage& message) {
  return {message.topic, message.id, message.extended};
}

void Joiner::add(ImportedMessage message, std::string_view file) {
  const auto [known, is_new] = known_.emplace(identity_of(message), network_.messages.size());
  if (is_new) {
    network_.messages.push_back(std::move(message));
    return;
  }
  auto& same = network_.messages[known->second];
  if (!same.senders.empty() && !message.senders.empty() && !may_have_senders(network_)) {
    add_lack(network_, "repeated", "another message has the identifier: left out", message,
             file.empty() || !message.file.empty() ? message.name
                                                   : fmt::format("{} of {}", message.name, file));
    return;
  }
  // The sender's statement about the type and size precedes a receiver's.
  if (same.senders.empty() && !message.senders.empty()) std::swap(same, message);
  join(same, std::move(message));
}

void Joiner::join(ImportedMessage& into, ImportedMessage from) {
  if (!into.type.empty() && !from.type.empty() && into.type != from.type)
    add_lack(network_, "types", "ends of one channel state different types", from,
             fmt::format("{}: {} and {}", into.name, into.type, from.type));
  if (into.format != from.format && !from.senders.empty()) into.format = core::FrameFormat::any;
  if (into.priority != from.priority && !from.senders.empty()) into.priority.reset();
  if (!from.senders.empty() && from.arrival == core::Arrival::sporadic) into.arrival = from.arrival;
  for (auto& sender : from.senders) {
    const auto same = [&](const ImportedEnd& other) {
      return other.node == sender.node && other.number == sender.number;
    };
    if (std::ranges::any_of(into.senders, same)) {
      add_lack(network_, "repeated-sender", "a node sends it already: left out", from,
               fmt::format("{} of {}", from.name, network_.nodes[sender.node].name));
      continue;
    }
    into.senders.push_back(with_own(sender, from.attributes, into.attributes));
  }
  for (const auto& receiver : from.receivers) add_receiver(into, receiver);
}

void merge(ImportedNetwork& into, ImportedNetwork from) {
  const auto places = join_nodes(into, from);
  name_file(into);
  for (auto& message : from.messages) message.file = from.file;
  Joiner joiner(into);
  for (auto& message : from.messages) {
    for (auto& sender : message.senders) sender.node = places[sender.node];
    for (auto& receiver : message.receivers) receiver.node = places[receiver.node];
    joiner.add(std::move(message), from.file);
  }
  if (into.bitrate == 0) into.bitrate = from.bitrate;
  if (into.data_bitrate == 0) into.data_bitrate = from.data_bitrate;
  if ((from.bitrate != 0 && from.bitrate != into.bitrate) ||
      (from.data_bitrate != 0 && from.data_bitrate != into.data_bitrate))
    into.lacks.add("bit-rates", "differ between nodes of one network: the first one counts", 0,
                   from.file);
  for (const auto& lack : from.lacks.all()) into.lacks.add(lack, from.file);
  into.file += ", " + from.file;
}

void complete(ImportedNetwork& network) {
  assume_bit_rates(network);
  name_senders(network);
  for (auto& message : network.messages) {
    for (auto& sender : message.senders) drop_same(sender, message.attributes);
    for (auto& receiver : message.receivers) drop_same(receiver, message.attributes);
  }
}

}  // namespace mlcca::tools::design
