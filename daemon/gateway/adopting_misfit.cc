// SPDX-License-Identifier: BSD-2-Clause
// Whether admissions of other gateways whose route crosses this one fit here.
#include <cstddef>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "daemon/gateway/adopting.hpp"
#include "daemon/gateway/requests/asked.hpp"

namespace mlcca {
namespace {

/// Whether it brings a publisher, or names one.
bool has_publisher(const control::Request& request) {
  return !std::get<control::Admit>(request.body).from.empty();
}

/// `other` with the publisher of `one`, which has one; nullopt if `other` brings its own, or names
/// another one.
std::optional<control::Request> with_publisher_of(const control::Request& one,
                                                  const control::Request& other) {
  const auto& first = std::get<control::Admit>(one.body);
  control::Request both = other;
  auto& second = std::get<control::Admit>(both.body);
  if (describes_publisher(second) || (!second.from.empty() && second.from != first.from))
    return std::nullopt;
  second.from = first.from;
  second.from_node = first.from_node;
  second.publisher = first.publisher;
  second.address = first.address;
  second.node = first.node;
  second.priority = first.priority;
  second.user = first.user;
  second.offered = first.offered;
  return both;
}

}  // namespace

/// Each request is tried alone, and one that only adds a subscriber also with publishers that come
/// with it. On average each request has one further try. What comes only for its publisher need not
/// fit.
std::string Adopting::misfit(const Adopted& adopted) const {
  if (!mapped(adopted)) return "it takes traffic of an admission that is not known here";
  std::size_t further = adopted.ours.size();
  std::vector<const control::Request*> publishers;
  for (std::size_t i = 0; i < adopted.ours.size(); ++i) {
    const control::Request& request = adopted.ours[i];
    std::string why = is_also(adopted, adopted.theirs[i]) ? std::string() : hands_.misfit(request);
    for (auto it = publishers.begin(); it != publishers.end() && !why.empty(); ++it) {
      const auto both = with_publisher_of(**it, request);
      if (!both) continue;
      if (further == 0) return why;
      --further;
      why = hands_.misfit(*both);
    }
    if (!why.empty()) return why;
    if (has_publisher(request)) publishers.push_back(&request);
  }
  return misfit_of_held(adopted);
}

/// Of what another admission of the same gateway holds, and this one asks for, too.
std::string Adopting::misfit_of_held(const Adopted& adopted) const {
  for (const WhichRequest& which : adopted.asks) {
    const auto* const held = requests_.held(which);
    const bool is_of_another = held != nullptr && held->holder != key_of(adopted);
    const control::Request* const there =
        is_of_another && !is_also(adopted, which) ? ours_of(which) : nullptr;
    if (there == nullptr) continue;
    if (std::string why = hands_.misfit(*there); !why.empty()) return why;
  }
  return {};
}

}  // namespace mlcca
