// SPDX-License-Identifier: BSD-2-Clause
#include "client/former_receivers.hpp"

#include <algorithm>

namespace mlcca::client {

bool FormerReceivers::Former::is(const Publisher& of, const SharedEndpoint& at) const {
  return receiver == at && !publisher.owner_before(of) && !of.owner_before(publisher);
}

void FormerReceivers::keep(const Publisher& publisher, const std::vector<SharedEndpoint>& receivers,
                           std::uint64_t until) {
  std::vector<Former> kept;
  kept.reserve(receivers.size());
  for (const SharedEndpoint& one : receivers)
    kept.push_back({publisher, one, this->until(publisher, one).value_or(until)});
  std::erase_if(all_, [&](const Former& one) {
    return one.publisher.expired() || one.is(publisher, one.receiver);
  });
  all_.insert(all_.end(), kept.begin(), kept.end());
}

std::optional<std::uint64_t> FormerReceivers::until(const Publisher& publisher,
                                                    const SharedEndpoint& receiver) const {
  const auto found =
      std::ranges::find_if(all_, [&](const Former& one) { return one.is(publisher, receiver); });
  if (found == all_.end()) return std::nullopt;
  return found->until;
}

bool FormerReceivers::forget(const Publisher& publisher, const SharedEndpoint& receiver) {
  return std::erase_if(all_, [&](const Former& one) { return one.is(publisher, receiver); }) != 0;
}

}  // namespace mlcca::client
