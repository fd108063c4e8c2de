// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/enforce/early.hpp"

#include <bpf/libbpf.h>
#include <linux/if_link.h>

#include "daemon/enforce/complaints.hpp"

namespace mlcca::enforce {

std::uint32_t early_program(std::uint32_t ifindex) {
  const Complaints unheard;
  std::uint32_t id = 0;
  return bpf_xdp_query_id(static_cast<int>(ifindex), XDP_FLAGS_DRV_MODE, &id) == 0 ? id : 0;
}

bool put_early(std::uint32_t ifindex, int program_fd, int ours_fd) {
  const Complaints unheard;
  LIBBPF_OPTS(bpf_xdp_attach_opts, options);
  options.old_prog_fd = ours_fd;
  const std::uint32_t how = ours_fd >= 0 ? XDP_FLAGS_REPLACE : XDP_FLAGS_UPDATE_IF_NOEXIST;
  return bpf_xdp_attach(static_cast<int>(ifindex), program_fd, XDP_FLAGS_DRV_MODE | how,
                        ours_fd >= 0 ? &options : nullptr) == 0;
}

}  // namespace mlcca::enforce
