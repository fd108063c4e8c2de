// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/roster.hpp"

#include <bpf/bpf.h>
#include <bpf/libbpf.h>
#include <roster.skel.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <memory>
#include <string_view>

#include "base/handle.hpp"
#include "bpf/gate.h"
#include "daemon/gates/complaints.hpp"
#include "daemon/gates/failure.hpp"

namespace mlcca::gates {
namespace {

using Object = std::unique_ptr<roster_bpf, FreeWith<roster_bpf__destroy>>;
using Link = std::unique_ptr<bpf_link, FreeWith<bpf_link__destroy>>;

struct Kind {
  std::string_view name;
  bool may_pass = true;
};
// The dead-man and the timers are not attached, so they are not listed.
constexpr std::array kKinds{
    Kind{"gate_ingress"},         Kind{"gate_egress"}, Kind{"ether_ingress"},
    Kind{"ether_egress"},         Kind{"ether_early"}, Kind{"closed_ingress", false},
    Kind{"closed_egress", false},
};

}  // namespace

Result<std::map<std::uint32_t, bool>> programs_of_gates() {
  const Complaints complaints;
  const Object object(roster_bpf__open_and_load());
  if (!object) return complaints.error("list the programs of gates", errno);
  const Link link(bpf_program__attach_iter(object->progs.gate_roster, nullptr));
  if (!link) return complaints.error("list the programs of gates", errno);
  const Fd list(bpf_iter_create(bpf_link__fd(link.get())));
  if (!list) return failure("list the programs of gates", errno);
  std::map<std::uint32_t, bool> programs;
  ssize_t size = 0;
  // The kernel returns complete entries, less than a page at once.
  std::array<gate_program, 128> some{};
  while ((size = ::read(list.get(), some.data(), sizeof(some))) > 0) {
    if (size % static_cast<ssize_t>(sizeof(gate_program)) != 0)
      return fail("list the programs of gates: an entry is cut off");
    for (std::size_t n = 0; n < static_cast<std::size_t>(size) / sizeof(gate_program); ++n) {
      const std::string_view name = static_cast<const char*>(some.at(n).name);
      const auto* const kind = std::ranges::find(kKinds, name, &Kind::name);
      if (kind != kKinds.end()) programs.emplace(some.at(n).id, kind->may_pass);
    }
  }
  if (size < 0) return failure("list the programs of gates", errno);
  return programs;
}

bool is_of_a_gate(std::uint32_t program) {
  const auto gates = programs_of_gates();
  return gates && gates->contains(program);
}

}  // namespace mlcca::gates
