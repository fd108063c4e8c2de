// SPDX-License-Identifier: BSD-2-Clause
// tc through libbpf's netlink calls, which act in the network namespace of the calling thread.
#include "daemon/gates/filters.hpp"

#include <bpf/libbpf.h>

#include <cerrno>
#include <string>

#include "daemon/gates/complaints.hpp"

namespace mlcca::gates {
namespace {

bpf_tc_hook hook_of(std::uint32_t ifindex, bpf_tc_attach_point point) {
  LIBBPF_OPTS(bpf_tc_hook, hook, .ifindex = static_cast<int>(ifindex), .attach_point = point);
  return hook;
}

bpf_tc_hook hook_of(std::uint32_t ifindex, Direction direction) {
  return hook_of(ifindex, direction == Direction::ingress ? BPF_TC_INGRESS : BPF_TC_EGRESS);
}

std::string name(Direction direction) { return to_text(direction) + std::string(" filter"); }

/// The handle of a second filter, which holds our place while our filter moves to the head of its
/// priority.
constexpr std::uint32_t kDeputy = GATE_TC_HANDLE + 1;

int attach(std::uint32_t ifindex, Direction direction, int program_fd, std::uint32_t flags,
           std::uint32_t handle = GATE_TC_HANDLE) {
  const auto hook = hook_of(ifindex, direction);
  LIBBPF_OPTS(bpf_tc_opts, options, .prog_fd = program_fd, .flags = flags, .prog_id = 0,
              .handle = handle, .priority = GATE_TC_PRIORITY);
  return bpf_tc_attach(&hook, &options);
}

int detach(std::uint32_t ifindex, Direction direction, std::uint32_t handle) {
  const auto hook = hook_of(ifindex, direction);
  LIBBPF_OPTS(bpf_tc_opts, options, .prog_fd = 0, .flags = 0, .prog_id = 0, .handle = handle,
              .priority = GATE_TC_PRIORITY);
  return bpf_tc_detach(&hook, &options);
}

}  // namespace

Result<std::uint32_t> program_in_place(std::uint32_t ifindex, Direction direction) {
  const Complaints complaints;
  const auto hook = hook_of(ifindex, direction);
  LIBBPF_OPTS(bpf_tc_opts, options, .prog_fd = 0, .flags = 0, .prog_id = 0,
              .handle = GATE_TC_HANDLE, .priority = GATE_TC_PRIORITY);
  const int error = bpf_tc_query(&hook, &options);
  // The kernel returns EINVAL if there is no clsact.
  if (error == -ENOENT || error == -EINVAL) return 0;
  if (error != 0) return complaints.error(name(direction), error);
  return options.prog_id;
}

Result<void> make_hooks(std::uint32_t ifindex) {
  const Complaints complaints;
  // libbpf takes a set of bits as its enum.
  // NOLINTNEXTLINE(clang-analyzer-optin.core.EnumCastOutOfRange)
  auto hook = hook_of(ifindex, static_cast<bpf_tc_attach_point>(BPF_TC_INGRESS | BPF_TC_EGRESS));
  const int error = bpf_tc_hook_create(&hook);
  if (error != 0 && error != -EEXIST) return complaints.error("clsact", error);
  return {};
}

Result<void> put_filter(std::uint32_t ifindex, Direction direction, int program_fd) {
  const Complaints complaints;
  const int error = attach(ifindex, direction, program_fd, BPF_TC_F_REPLACE);
  if (error != 0) return complaints.error(name(direction), error);
  detach(ifindex, direction, kDeputy);  // left by a daemon that ended in put_filter_first()
  return {};
}

Result<bool> put_filter_if_empty(std::uint32_t ifindex, Direction direction, int program_fd) {
  const Complaints complaints;
  const int error = attach(ifindex, direction, program_fd, 0);
  if (error == -EEXIST) return false;
  if (error != 0) return complaints.error(name(direction), error);
  return true;
}

/// The kernel puts a new filter at the head of its priority, and a replacing one in the place of
/// the former.
Result<void> put_filter_first(std::uint32_t ifindex, Direction direction, int program_fd) {
  const Complaints complaints;
  detach(ifindex, direction, kDeputy);
  for (const std::uint32_t handle : {kDeputy, std::uint32_t{GATE_TC_HANDLE}}) {
    if (handle == GATE_TC_HANDLE) detach(ifindex, direction, handle);
    if (const int error = attach(ifindex, direction, program_fd, 0, handle); error != 0)
      return complaints.error(name(direction), error);
  }
  detach(ifindex, direction, kDeputy);
  return {};
}

void remove_filter(std::uint32_t ifindex, Direction direction) {
  const Complaints complaints;
  detach(ifindex, direction, GATE_TC_HANDLE);
  detach(ifindex, direction, kDeputy);
}

}  // namespace mlcca::gates
