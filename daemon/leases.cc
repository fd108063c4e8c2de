// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/leases.hpp"

namespace mlcca {

void Leases::end_at(std::uint64_t id, Lease& lease, std::uint64_t now) {
  by_end_.erase({lease.end, id});
  lease.end = lease.length_ns > kUnbounded - now ? kUnbounded : now + lease.length_ns;
  if (lease.end != kUnbounded) by_end_.emplace(lease.end, id);
}

void Leases::set(std::uint64_t id, std::uint64_t length_ns, std::uint64_t now) {
  Lease& lease = by_id_[id];
  lease.length_ns = length_ns;
  end_at(id, lease, now);
}

void Leases::renew(std::uint64_t id, std::uint64_t now) {
  const auto found = by_id_.find(id);
  if (found != by_id_.end()) end_at(id, found->second, now);
}

void Leases::forget(std::uint64_t id) {
  const auto found = by_id_.find(id);
  if (found == by_id_.end()) return;
  by_end_.erase({found->second.end, id});
  by_id_.erase(found);
}

std::vector<std::uint64_t> Leases::expired(std::uint64_t now) const {
  std::vector<std::uint64_t> ids;
  for (const auto& [end, id] : by_end_) {
    if (end > now) break;
    ids.push_back(id);
  }
  return ids;
}

std::uint64_t Leases::next_deadline() const {
  return by_end_.empty() ? kUnbounded : by_end_.begin()->first;
}

std::optional<std::uint64_t> Leases::remaining(std::uint64_t id, std::uint64_t now) const {
  const auto found = by_id_.find(id);
  if (found == by_id_.end()) return std::nullopt;
  const std::uint64_t end = found->second.end;
  if (end == kUnbounded) return kUnbounded;
  return end > now ? end - now : 0;
}

}  // namespace mlcca
