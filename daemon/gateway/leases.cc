// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/leases.hpp"

namespace mlcca {

void Leases::end_after(std::uint64_t id, Lease& lease, std::uint64_t ns, std::uint64_t now) {
  by_end_.erase({lease.end, id});
  lease.end = ns > kUnbounded - now ? kUnbounded : now + ns;
  if (lease.end != kUnbounded) by_end_.emplace(lease.end, id);
}

void Leases::set(std::uint64_t id, std::uint64_t length_ns, std::uint64_t now) {
  Lease& lease = by_id_[id];
  lease.length_ns = length_ns;
  end_after(id, lease, length_ns, now);
}

void Leases::renew(std::uint64_t id, std::uint64_t now) {
  const auto found = by_id_.find(id);
  if (found != by_id_.end()) end_after(id, found->second, found->second.length_ns, now);
}

void Leases::postpone(std::uint64_t id, std::uint64_t by_ns, std::uint64_t now) {
  const auto found = by_id_.find(id);
  if (found != by_id_.end()) end_after(id, found->second, by_ns, now);
}

void Leases::forget(std::uint64_t id) {
  const auto found = by_id_.find(id);
  if (found == by_id_.end()) return;
  by_end_.erase({found->second.end, id});
  by_id_.erase(found);
}

std::vector<std::uint64_t> Leases::expired(std::uint64_t now, std::size_t most) const {
  std::vector<std::uint64_t> ids;
  for (const auto& [end, id] : by_end_) {
    if (end > now || ids.size() >= most) break;
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
