// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/permit_watch.hpp"

#include <utility>

namespace mlcca::core {

void PermitWatch::reset(std::size_t networks) {
  grown_.assign(networks, 0);
  shrunk_.assign(networks, 0);
  more_agreed_ = less_agreed_ = 0;
}

bool PermitWatch::has_seen(const Permits& permits) const {
  for (std::size_t n = 0; n < grown_.size(); ++n)
    if (permits.grown(n) != grown_[n] || permits.shrunk(n) != shrunk_[n]) return false;
  return permits.more_agreed() == more_agreed_ && permits.less_agreed() == less_agreed_;
}

PermitWatch::Changes PermitWatch::poll(const Permits& permits) {
  Changes changes;
  for (std::size_t n = 0; n < grown_.size(); ++n) {
    const bool more = std::exchange(grown_[n], permits.grown(n)) != permits.grown(n);
    const std::uint64_t before = std::exchange(shrunk_[n], permits.shrunk(n));
    const bool less = before != permits.shrunk(n);
    if (more || less) changes.networks.push_back(n);
    if (less) changes.ended.push_back({n, before});
    changes.more = changes.more || more;
  }
  if (const std::uint64_t before = std::exchange(less_agreed_, permits.less_agreed());
      before != less_agreed_)
    changes.disagreed_since = before;
  const std::uint64_t before = std::exchange(more_agreed_, permits.more_agreed());
  changes.more = changes.more || before != more_agreed_;
  return changes;
}

}  // namespace mlcca::core
