// SPDX-License-Identifier: BSD-2-Clause
// The bpf system call itself: the library and the headers of Debian 12 are older than TCX. Layouts
// are those of <linux/bpf.h> of Linux 6.6.
#include "daemon/enforce/tcx.hpp"

#include <bpf/bpf.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "daemon/enforce/failure.hpp"

namespace mlcca::enforce {
namespace {

constexpr std::uint32_t kTcxIngress = 46;
constexpr std::uint32_t kTcxEgress = 47;
constexpr std::uint32_t kBefore = 1U << 3;  // BPF_F_BEFORE; of nothing: of all
constexpr std::uint32_t kLinkOfTcx = 11;    // BPF_LINK_TYPE_TCX
constexpr std::size_t kMostPrograms = 64;   // the kernel's own limit
constexpr std::uint32_t kLoopback = 1;      // the first interface of every network namespace

struct LinkCreate {
  std::uint32_t program = 0;
  std::uint32_t ifindex = 0;
  std::uint32_t attach_type = 0;
  std::uint32_t flags = 0;
  std::uint32_t relative = 0;
  std::uint32_t pad = 0;
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

struct LinkInfo {
  std::uint32_t type = 0;
  std::uint32_t id = 0;
  std::uint32_t program = 0;
  std::uint32_t pad = 0;
  std::uint32_t ifindex = 0;
  std::uint32_t attach_type = 0;
  std::array<std::uint64_t, 8> rest{};  // other kinds of links say more
};

template <class Attributes>
int bpf_call(int command, Attributes& attributes) {
  // NOLINTNEXTLINE(*-vararg)
  return static_cast<int>(::syscall(SYS_bpf, command, &attributes, sizeof(attributes)));
}

std::uint32_t type_of(Direction direction) {
  return direction == Direction::ingress ? kTcxIngress : kTcxEgress;
}

}  // namespace

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

Result<Fd> tcx_attach_first(std::uint32_t ifindex, Direction direction, int program_fd) {
  LinkCreate create;
  create.program = static_cast<std::uint32_t>(program_fd);
  create.ifindex = ifindex;
  create.attach_type = type_of(direction);
  create.flags = kBefore;
  Fd link(bpf_call(BPF_LINK_CREATE, create));
  if (!link) return failure("tcx link", errno);
  return link;
}

Result<void> tcx_update(int link_fd, int program_fd) {
  if (bpf_link_update(link_fd, program_fd, nullptr) != 0) return failure("tcx link", errno);
  return {};
}

void tcx_detach(int link_fd) { bpf_link_detach(link_fd); }

std::uint32_t tcx_program(int link_fd, std::uint32_t ifindex) {
  LinkInfo info;
  std::uint32_t size = sizeof(info);
  // NOLINTNEXTLINE(bugprone-multi-level-implicit-pointer-conversion)
  if (bpf_obj_get_info_by_fd(link_fd, &info, &size) != 0 || info.type != kLinkOfTcx) return 0;
  return info.ifindex == ifindex ? info.program : 0;
}

}  // namespace mlcca::enforce
