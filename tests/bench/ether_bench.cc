// SPDX-License-Identifier: BSD-2-Clause
// What the Ethernet gate costs: ns of a datagram above an empty program, by BPF_PROG_TEST_RUN. One
// packet again and again, and another subject each time, among many. Prints JSON.
#include <bpf/bpf.h>
#include <bpf/libbpf.h>
#include <fmt/format.h>
#include <linux/pkt_cls.h>
#include <shuffle.skel.h>
#include <sys/mman.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "tests/bench/timing.hpp"
#include "tests/bpf/ether/loaded_ether.hpp"

namespace mlcca::test {
namespace {

using gates::Direction;
using gates::SlotSpec;

constexpr int kRuns = 400;  // the best of so many, each shorter than a turn of the scheduler
constexpr int kRepeat = 20'000;

/// A packet that is repeated keeps what is written into it: mark 0 again is egress' own.
double nanoseconds_of(int program, const Bytes& bytes) {
  return best_of(kRuns, kRepeat, [&](int repeat) {
    __sk_buff context{};
    context.priority = 1;  // locally sent
    LIBBPF_OPTS(bpf_test_run_opts, options);
    options.data_in = bytes.data();
    options.data_size_in = static_cast<std::uint32_t>(bytes.size());
    options.ctx_in = &context;
    options.ctx_size_in = sizeof(context);
    options.repeat = repeat;
    if (bpf_prog_test_run_opts(program, &options) != 0) std::abort();
  });
}

SlotSpec slot(std::uint64_t subject) {
  SlotSpec s;
  s.direction = Direction::egress;
  s.pass = true;
  s.subject = subject;
  s.formats = ETHER_UNFRAGMENTED;
  return s;
}

/// Calls a program with another subject each time.
class Shuffle {
 public:
  explicit Shuffle(const std::vector<std::uint64_t>& known)
      : object_(shuffle_bpf__open(), shuffle_bpf__destroy) {
    object_->rodata->known_count = static_cast<std::uint32_t>(known.size());
    if (shuffle_bpf__load(object_.get()) != 0) std::abort();
    if (known.empty()) return;
    const std::size_t size = known.size() * sizeof(std::uint64_t);
    void* memory = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED,
                        bpf_map__fd(object_->maps.known), 0);
    if (memory == MAP_FAILED) std::abort();
    std::ranges::copy(known, static_cast<std::uint64_t*>(memory));
    munmap(memory, size);
  }
  [[nodiscard]] double nanoseconds(int program, const Bytes& bytes) const {
    const std::uint32_t key = 0;
    if (bpf_map_update_elem(bpf_map__fd(object_->maps.measured), &key, &program, BPF_ANY) != 0)
      std::abort();
    return nanoseconds_of(bpf_program__fd(object_->progs.shuffle), bytes);
  }

 private:
  std::unique_ptr<shuffle_bpf, void (*)(shuffle_bpf*)> object_;
};

std::string row(const std::string& name, double ns, double empty) {
  return fmt::format("  {{\"name\": \"{}\", \"ns\": {:.1f}, \"above_empty_ns\": {:.1f}}}", name, ns,
                     ns - empty);
}

void print() {
  const Fd nothing = empty_program();
  const Bytes packet = frame(Datagram{.subject = 1}.whole());
  const Bytes unknown = frame(Datagram{.subject = 2}.whole());
  const Bytes foreign = frame(Datagram{.subject = 1, .port = 53}.whole());
  const Bytes tcp = frame(Datagram{.subject = 1, .protocol = 6}.whole());
  const double empty = nanoseconds_of(nothing.get(), packet);
  std::vector<std::string> rows;

  auto& small = LoadedEther::with();
  SlotSpec policed = slot(3);
  policed.per_frame = 1;
  policed.tolerance = 3'600'000'000'000;
  small.admit({slot(1), policed});
  const int program = small.program_fd(Direction::egress);
  const auto measure = [&](const std::string& name, const Bytes& bytes) {
    rows.push_back(row(name, nanoseconds_of(program, bytes), empty));
  };
  measure("hit", packet);
  measure("hit, policed", frame(Datagram{.subject = 3}.whole()));
  measure("miss", unknown);
  measure("other UDP", foreign);
  measure("TCP", tcp);
  auto& loads = LoadedEther::with({.direct_access = false});
  loads.admit({slot(1)});
  rows.push_back(row("hit, portable loads",
                     nanoseconds_of(loads.program_fd(Direction::egress), packet), empty));

  // 10^6 subjects on one interface, another one each time.
  constexpr std::size_t many = 1'000'000;
  LoadedEther large({.slots = many});
  std::mt19937_64 random(7);
  std::vector<std::uint64_t> known(many);
  std::ranges::generate(known, [&] { return random(); });
  std::vector<SlotSpec> specs;
  for (const std::uint64_t subject : known) specs.push_back(slot(subject));
  large.admit(specs);
  const Shuffle hits(known);
  const Shuffle misses({});
  const int big = large.program_fd(Direction::egress);
  const double empty_hits = hits.nanoseconds(nothing.get(), packet);
  const double empty_misses = misses.nanoseconds(nothing.get(), packet);
  rows.push_back(
      row("hit, another of 10^6 subjects each time", hits.nanoseconds(big, packet), empty_hits));
  rows.push_back(row("miss, another of 2^64 subjects each time, 10^6 known",
                     misses.nanoseconds(big, packet), empty_misses));
  const Bytes one = frame(Datagram{.subject = known[5]}.whole());
  rows.push_back(row("hit, the same of 10^6 subjects", nanoseconds_of(big, one), empty));
  rows.push_back(row("miss, the same subject, 10^6 known", nanoseconds_of(big, unknown), empty));

  fmt::print("{{\"floor\": \"empty tc program\", \"floor_ns\": {:.1f}, \"cases\": [\n", empty);
  for (std::size_t i = 0; i < rows.size(); ++i)
    fmt::print("{}{}\n", rows[i], i + 1 < rows.size() ? "," : "");
  fmt::print("]}}\n");
}

}  // namespace
}  // namespace mlcca::test

int main() {
  mlcca::test::print();
  return 0;
}
