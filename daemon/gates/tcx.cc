// SPDX-License-Identifier: BSD-2-Clause
// Calls the bpf system call itself, because the library and the headers of Debian 12 are older than
// TCX. The layouts are those of <linux/bpf.h> of Linux 6.6.
#include "daemon/gates/tcx.hpp"

#include <bpf/bpf.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "daemon/gates/failure.hpp"

namespace mlcca::gates {
namespace {

constexpr std::uint32_t kTcxIngress = 46;
constexpr std::uint32_t kTcxEgress = 47;
constexpr std::uint32_t kReplace = 1U << 2;  // BPF_F_REPLACE
constexpr std::uint32_t kBefore = 1U << 3;   // BPF_F_BEFORE; without a relative program: before all
constexpr std::uint32_t kAfter = 1U << 4;    // BPF_F_AFTER
constexpr std::uint32_t kById = 1U << 5;     // BPF_F_ID
constexpr std::size_t kMostPrograms = 64;    // the limit of the kernel

struct Attach {
  std::uint32_t ifindex = 0;
  std::uint32_t program = 0;
  std::uint32_t attach_type = 0;
  std::uint32_t flags = 0;
  std::uint32_t former = 0;
  std::uint32_t relative = 0;
  std::uint64_t expected_revision = 0;
};

struct Query {
  std::uint32_t ifindex = 0;
  std::uint32_t attach_type = 0;
  std::uint32_t query_flags = 0;
  std::uint32_t attach_flags = 0;
  std::uint64_t program_ids = 0;
  std::uint32_t count = 0;
  std::uint32_t pad = 0;
  std::uint64_t program_attach_flags = 0;
  std::uint64_t link_ids = 0;
  std::uint64_t link_attach_flags = 0;
  std::uint64_t revision = 0;
};

template <class Attributes>
int bpf_call(int command, Attributes& attributes) {
  // NOLINTNEXTLINE(*-vararg)
  return static_cast<int>(::syscall(SYS_bpf, command, &attributes, sizeof(attributes)));
}

std::uint32_t type_of(Direction direction) {
  return direction == Direction::ingress ? kTcxIngress : kTcxEgress;
}

Attach attributes(std::uint32_t ifindex, Direction direction) {
  Attach attach;
  attach.ifindex = ifindex;
  attach.attach_type = type_of(direction);
  return attach;
}

}  // namespace

bool TcxOrder::has(std::uint32_t program) const {
  return program != 0 && std::ranges::find(programs, program) != programs.end();
}

Result<std::optional<TcxOrder>> tcx_order(std::uint32_t ifindex, Direction direction) {
  std::array<std::uint32_t, kMostPrograms> ids{};
  Query query;
  query.ifindex = ifindex;
  query.attach_type = type_of(direction);
  query.program_ids = reinterpret_cast<std::uintptr_t>(ids.data());
  query.count = ids.size();
  if (bpf_call(BPF_PROG_QUERY, query) != 0) {
    if (errno == EINVAL) return std::nullopt;
    return failure("tcx query", errno);
  }
  const auto count = std::min<std::size_t>(query.count, ids.size());
  return TcxOrder{.revision = query.revision,
                  .programs = {ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(count)}};
}

bool kernel_has_tcx() {
  const auto order = tcx_order(kLoopback, Direction::ingress);
  return order && *order;
}

Result<void> tcx_attach_first(std::uint32_t ifindex, Direction direction, int program_fd) {
  Attach attach = attributes(ifindex, direction);
  attach.program = static_cast<std::uint32_t>(program_fd);
  attach.flags = kBefore;
  if (bpf_call(BPF_PROG_ATTACH, attach) != 0) return failure("tcx attach", errno);
  return {};
}

Result<void> tcx_replace(std::uint32_t ifindex, Direction direction, int former_fd,
                         int program_fd) {
  Attach attach = attributes(ifindex, direction);
  attach.program = static_cast<std::uint32_t>(program_fd);
  attach.former = static_cast<std::uint32_t>(former_fd);
  attach.flags = kReplace;
  if (bpf_call(BPF_PROG_ATTACH, attach) != 0) return failure("tcx replace", errno);
  return {};
}

Result<void> tcx_detach(std::uint32_t ifindex, Direction direction, int program_fd) {
  Attach detach = attributes(ifindex, direction);
  detach.program = static_cast<std::uint32_t>(program_fd);
  if (bpf_call(BPF_PROG_DETACH, detach) != 0) return failure("tcx detach", errno);
  return {};
}

Result<void> tcx_detach_beside(std::uint32_t ifindex, Direction direction, const TcxOrder& order,
                               std::uint32_t program) {
  const auto it = std::ranges::find(order.programs, program);
  if (it == order.programs.end() || order.programs.size() < 2) return failure("tcx detach", ENOENT);
  const auto at = static_cast<std::size_t>(it - order.programs.begin());
  Attach detach = attributes(ifindex, direction);
  detach.relative = order.programs[at == 0 ? 1 : at - 1];
  detach.flags = kById | (at == 0 ? kBefore : kAfter);
  detach.expected_revision = order.revision;
  if (bpf_call(BPF_PROG_DETACH, detach) != 0) return failure("tcx detach", errno);
  return {};
}

}  // namespace mlcca::gates
