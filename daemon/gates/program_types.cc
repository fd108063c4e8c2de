// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/program_types.hpp"

#include <bpf/bpf.h>
#include <bpf/btf.h>
#include <bpf/libbpf.h>
#include <linux/bpf.h>
#include <linux/btf.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/handle.hpp"
#include "daemon/gates/complaints.hpp"
#include "daemon/gates/failure.hpp"

namespace mlcca::gates {
namespace {

using Types = std::unique_ptr<btf, FreeWith<btf__free>>;

/// 0 if the types have a global function. -EAGAIN: libbpf takes the kernel for too old, and makes
/// functions static. Another errno: the kernel did not answer.
int check_global_function(int types_fd) {
  bpf_btf_info info{};
  std::uint32_t size = sizeof info;
  if (const int error = bpf_obj_get_info_by_fd(types_fd, &info, &size); error != 0) return error;
  std::vector<std::uint8_t> bytes(info.btf_size);
  info = {};
  info.btf = reinterpret_cast<std::uintptr_t>(bytes.data());  // NOLINT(*-reinterpret-cast)
  info.btf_size = static_cast<std::uint32_t>(bytes.size());
  size = sizeof info;
  if (const int error = bpf_obj_get_info_by_fd(types_fd, &info, &size); error != 0) return error;
  const Types types(btf__new(bytes.data(), static_cast<std::uint32_t>(bytes.size())));
  if (!types) return -errno;
  for (std::uint32_t id = 1; id < btf__type_cnt(types.get()); ++id) {
    const btf_type* const type = btf__type_by_id(types.get(), id);
    if (btf_is_func(type) && BTF_INFO_VLEN(type->info) == BTF_FUNC_GLOBAL) return 0;
  }
  return -EAGAIN;
}

int prepare(bpf_program* /*program*/, bpf_prog_load_opts* load, long /*cookie*/) noexcept {
  if (load->prog_btf_fd == 0 || load->func_info_cnt == 0) return -EAGAIN;
  return check_global_function(static_cast<int>(load->prog_btf_fd));
}

/// Registers handlers for the life of the process: objects keep pointers into libbpf's table of
/// handlers.
int register_once() {
  LIBBPF_OPTS(libbpf_prog_handler_opts, handler, .prog_prepare_load_fn = prepare);
  const int tc = libbpf_register_prog_handler("tc", BPF_PROG_TYPE_SCHED_CLS, {}, &handler);
  if (tc < 0) return tc;
  const int xdp = libbpf_register_prog_handler("xdp", BPF_PROG_TYPE_XDP, BPF_XDP, &handler);
  if (xdp < 0) libbpf_unregister_prog_handler(tc);
  return xdp < 0 ? xdp : 0;
}

}  // namespace

Result<void> demand_types() {
  static bool registered = false;
  if (registered) return {};
  const Complaints complaints;
  if (const int error = register_once(); error != 0)
    return complaints.error("prepare libbpf for programs with types", error);
  registered = true;
  return {};
}

Result<void> probed_without_failure(const bpf_map* memory, int program_fd) {
  if ((bpf_map__map_flags(memory) & BPF_F_MMAPABLE) == 0)
    return fail("libbpf could not ask the kernel whether maps can be mapped");
  bpf_prog_info info{};
  std::uint32_t size = sizeof info;
  if (bpf_obj_get_info_by_fd(program_fd, &info, &size) != 0)
    return failure("ask for the name of a program", errno);
  if (info.name[0] == '\0')
    return fail("libbpf could not ask the kernel whether programs can have names");
  return {};
}

}  // namespace mlcca::gates
