// SPDX-License-Identifier: BSD-2-Clause
// The real mlccad on veth pairs: from exec to the first heart-beat, which keeps in force what a
// daemon before it has left, and to all gates in force; from exec of --close to a closed interface.
#include <bpf/bpf.h>
#include <fmt/core.h>
#include <linux/bpf.h>
#include <net/if.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "daemon/gates/tcx.hpp"
#include "tests/daemon/start/daemon.hpp"

namespace mlcca::test {
namespace {

constexpr int kRuns = 5;

double ms(std::uint64_t ns) { return static_cast<double>(ns) / 1e6; }

template <class T>
T median(std::vector<T> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

struct Times {
  std::uint64_t beat = 0;  ///< 0: none before all was in force
  std::uint64_t in_force = 0;
};

/// One start, killed when its gates are in force.
Times start(const Gateway& gateway) {
  const auto word = gateway.word();
  const std::uint64_t before = word ? word[0].heartbeat : 0;
  Process daemon(gateway.command(), gateway.path("log"));
  Times times;
  const bool ready = daemon.ready([&] {
    if (word && times.beat == 0 && __atomic_load_n(&word[0].heartbeat, __ATOMIC_ACQUIRE) != before)
      times.beat = clock_ns() - daemon.began();
  });
  times.in_force = clock_ns() - daemon.began();
  if (!ready) {
    fmt::print(stderr, "{}", gateway.log());
    std::exit(1);
  }
  daemon.signal(SIGKILL);
  return times;
}

std::string many_channels(int count) {
  std::string out;
  for (int i = 0; i < count; ++i)
    out += fmt::format("<EventChannel name=\"m{}\"><SubjectUID>{:#x}</SubjectUID></EventChannel>\n",
                       i, 0x100000 + i);
  return out;
}

/// A start loads and verifies the programs of each port: of many ports one restart has to do.
void row(const std::string& what, const std::string& description, int runs = kRuns) {
  const Gateway gateway(description);
  const Times first = start(gateway);
  std::vector<std::uint64_t> beats;
  std::vector<std::uint64_t> in_force;
  for (int run = 0; run < runs; ++run) {
    const Times again = start(gateway);
    beats.push_back(again.beat);
    in_force.push_back(again.in_force);
  }
  fmt::print("{:<34} {:10.1f} {:14.1f} {:14.1f}\n", what, ms(first.in_force), ms(median(beats)),
             ms(median(in_force)));
}

std::uint64_t time_of(std::vector<std::string> command, const Gateway& gateway) {
  Process process(std::move(command), gateway.path("log"));
  const int status = process.end();
  if (status != 0) {
    fmt::print(stderr, "exit status {}: {}", status, gateway.log());
    std::exit(1);
  }
  return clock_ns() - process.began();
}

/// A program that passes everything.
Fd empty_program() {
  const bpf_insn code[] = {
      {.code = BPF_ALU64 | BPF_MOV | BPF_K,
       .dst_reg = BPF_REG_0,
       .src_reg = 0,
       .off = 0,
       .imm = -1},
      {.code = BPF_JMP | BPF_EXIT, .dst_reg = 0, .src_reg = 0, .off = 0, .imm = 0}};
  return Fd(bpf_prog_load(BPF_PROG_TYPE_SCHED_CLS, nullptr, "GPL", code, std::size(code), nullptr));
}

/// What the kernel alone takes to attach a program in both directions: it waits for a grace period
/// of RCU in each call, and the first one of a machine takes effect behind that. 0: it has no TCX.
std::uint64_t time_to_attach(const std::string& interface) {
  if (!gates::kernel_has_tcx()) return 0;
  const Fd program = empty_program();
  const auto ifindex = if_nametoindex(interface.c_str());
  const std::uint64_t began = clock_ns();
  for (const auto direction : {gates::Direction::egress, gates::Direction::ingress})
    if (!gates::tcx_attach_first(ifindex, direction, program.get())) std::exit(1);
  return clock_ns() - began;
}

/// `make` is an ip(8) command that makes the interface of that name.
void close_row(const std::string& what, const std::string& make) {
  const Gateway gateway("");
  std::vector<std::uint64_t> closed;
  std::vector<std::uint64_t> floor;
  std::vector<std::uint64_t> attach;
  const auto shell = [](const std::string& line) {
    // NOLINTNEXTLINE(cert-env33-c,concurrency-mt-unsafe)
    if (std::system(line.c_str()) != 0) std::exit(1);
  };
  for (int run = 0; run < 4 * kRuns; ++run) {
    const std::string name = "x" + std::to_string(run);
    shell(fmt::format(fmt::runtime(make), name));
    attach.push_back(time_to_attach(name));
    shell(fmt::format("ip link del {}", name));
    shell(fmt::format(fmt::runtime(make), name));
    auto command = gateway.command({"--close", name});
    closed.push_back(time_of(command, gateway));
    floor.push_back(time_of({"mlccad", "--version"}, gateway));
    shell(fmt::format("ip link del {}", name));
  }
  const auto least = median(floor) + median(attach);
  fmt::print(
      "{:<34} {:10.1f}   the same program doing nothing {:.1f}, the kernel's two attachments "
      "of an empty one {:.1f}   ratio to both {:.2f}\n",
      what, ms(median(closed)), ms(median(floor)), ms(median(attach)),
      static_cast<double>(median(closed)) / static_cast<double>(least));
}

}  // namespace
}  // namespace mlcca::test

int main(int argc, char** argv) {
  using namespace mlcca::test;  // NOLINT(google-build-using-namespace): the program itself
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  int most = 256;
  if (argc > 1) std::from_chars(argv[1], argv[1] + std::string_view(argv[1]).size(), most);
  make_links(most);
  fmt::print("{:<34} {:>10}\n", "ms", "median");
  close_row("exec to closed, Ethernet", "ip link add {0} type veth peer name p{0}");
  close_row("exec to closed, the program of CAN", "ip tuntap add dev {0} mode tun");
  fmt::print("{:<34} {:>10} {:>14} {:>14}\n", "ms from exec", "first start", "restart: beat",
             "in force");
  for (const int ports : {1, 16, 256})
    if (ports <= most)
      row(fmt::format("{} ports, Ethernet", ports), described(ports), ports > 16 ? 1 : kRuns);
  row("1 port, 100000 channels", described(1, many_channels(100'000)));
}
