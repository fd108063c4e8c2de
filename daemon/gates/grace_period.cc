// SPDX-License-Identifier: BSD-2-Clause
// membarrier(MEMBARRIER_CMD_GLOBAL) is synchronize_rcu(). A change of a map of maps waits as well:
// the kernel finishes it only when no program can hold the old inner map (bpf(2), since 4.18).
#include "daemon/gates/grace_period.hpp"

#include <bpf/bpf.h>
#include <linux/membarrier.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>

#include "base/handle.hpp"
#include "daemon/gates/failure.hpp"

namespace mlcca::gates {

Result<void> detail::wait_by_membarrier() {
  if (syscall(SYS_membarrier, MEMBARRIER_CMD_GLOBAL, 0, 0) != 0)
    return failure("membarrier", errno);
  return {};
}

Result<void> detail::wait_by_map_of_maps() {
  const Fd inner(bpf_map_create(BPF_MAP_TYPE_ARRAY, "mlcca_grace", 4, 4, 1, nullptr));
  if (!inner) return failure("bpf map for a grace period", errno);
  LIBBPF_OPTS(bpf_map_create_opts, options,
              .inner_map_fd = static_cast<std::uint32_t>(inner.get()));
  const Fd outer(bpf_map_create(BPF_MAP_TYPE_ARRAY_OF_MAPS, "mlcca_grace", 4, 4, 1, &options));
  if (!outer) return failure("bpf map of maps for a grace period", errno);
  const std::uint32_t key = 0;
  const int value = inner.get();
  if (bpf_map_update_elem(outer.get(), &key, &value, BPF_ANY) != 0)
    return failure("bpf map update for a grace period", errno);
  return {};
}

Result<void> wait_for_grace_period() {
  if (detail::wait_by_membarrier()) return {};
  return detail::wait_by_map_of_maps();
}

}  // namespace mlcca::gates
