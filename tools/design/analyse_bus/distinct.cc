// SPDX-License-Identifier: BSD-2-Clause
// Finds names of messages and identifiers of senders that occur twice on a bus.
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <tuple>

#include "tools/design/analyse_bus/bus.hpp"

namespace mlcca::tools::design {
namespace {

using core::can::kOwnQueue;

/// Whether both wait in the same queue, and so have one sender.
bool same_sender(const BusMessage& a, const BusMessage& b) {
  return a.message.queue != kOwnQueue && a.message.queue == b.message.queue;
}

/// Calls `found(first, again)` for each message whose key an earlier message has, too.
template <class Key, class Found>
void for_each_again(const std::vector<BusMessage>& messages, const Key& key, const Found& found) {
  std::vector<std::size_t> order(messages.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return key(messages[i]); });
  for (std::size_t i = 1, first = 0; i < order.size(); ++i) {
    if (key(messages[order[i]]) != key(messages[order[first]]))
      first = i;
    else
      found(messages[order[first]], messages[order[i]]);
  }
}

}  // namespace

std::vector<std::string> problems_of(const std::vector<BusMessage>& messages,
                                     const std::string& network) {
  std::vector<std::string> problems;
  const std::string on = network.empty() ? "" : " on " + network;
  for_each_again(
      messages,
      [](const BusMessage& m) {
        // Tags that a broker has not assigned yet differ from all others.
        return std::tuple(m.id, m.extended, m.tag_known ? 0 : m.message.key + 1);
      },
      [&](const BusMessage& first, const BusMessage& again) {
        if (same_sender(first, again)) return;
        problems.push_back(fmt::format(
            "{}: identifier 0x{:x} of {}{} is that of {} already, from {}: an identifier has one "
            "sender on a bus, and no bound holds otherwise",
            again.where, again.id, again.name, on, first.name, first.where));
      });
  for_each_again(
      messages, [](const BusMessage& m) { return m.name; },
      [&](const BusMessage& first, const BusMessage& again) {
        problems.push_back(fmt::format("{}: the name {} is already taken in {}: names are unique",
                                       again.where, again.name, first.where));
      });
  return problems;
}

}  // namespace mlcca::tools::design
