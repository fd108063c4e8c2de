// SPDX-License-Identifier: BSD-2-Clause
// What is not said in one turn of the loop, because there is too much of it.
#include <algorithm>

#include "daemon/gateway/gateway.hpp"
#include "daemon/gateway/report_size.hpp"

namespace mlcca {
namespace {

/// Channels with troubles, each of which is looked into.
constexpr std::size_t kManyTroubled = 32;
/// Verdicts of a channel, or publishers and subscribers.
constexpr std::size_t kManyEnds = 256;

}  // namespace

/// Of all that there is, whichever part of it a report lists.
bool Gateway::is_large() const {
  std::size_t lines = forwarder_.rules();
  for (std::size_t p = 0; p < ports_.size(); ++p)
    if (const auto* gate = ports_.gate(p)) lines += gate->size();
  for (std::size_t n = 0; n < scene_.state->system().networks.size(); ++n)
    if (const auto* table = meshes_.table(n)) lines += table->size();
  return lines > kMostLines || lines + lines_of(*scene_.state, kMostLines - lines) > kMostLines;
}

bool Gateway::has_much_trouble() const {
  if (troubled_.size() > kManyTroubled) return true;
  return std::ranges::any_of(troubled_, [this](std::size_t channel) {
    return channel < scene_.state->decisions().size() &&
           scene_.state->decisions()[channel].verdicts.size() > kManyEnds;
  });
}

bool Gateway::has_many_ends(std::size_t channel) const {
  const core::Members& members = scene_.state->members();
  return scene_.state->decisions()[channel].verdicts.size() > kManyEnds ||
         members.publishers_of(channel).size() + members.subscribers_of(channel).size() > kManyEnds;
}

bool Gateway::has_many_lines(std::size_t channel) const {
  if (has_many_ends(channel)) return true;
  std::size_t lines = 0;
  for (const core::Verdict& v : scene_.state->decisions()[channel].verdicts)
    lines += lines_of(*scene_.state, v);
  return lines > kMostLines;
}

bool Gateway::has_channel_of_many_ends() const {
  for (std::size_t c = 0; c < scene_.state->decisions().size(); ++c)
    if (has_many_ends(c)) return true;
  return false;
}

}  // namespace mlcca
