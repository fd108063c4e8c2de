// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/enforce/watchmen.hpp"

#include <bpf/bpf.h>
#include <bpf/libbpf.h>
#include <poll.h>
#include <watch.skel.h>

#include <array>
#include <cerrno>

#include "daemon/enforce/complaints.hpp"
#include "daemon/enforce/failure.hpp"
#include "daemon/enforce/pins.hpp"

namespace mlcca::enforce {
namespace {

/// Milliseconds apart: the kernel takes no lock for the memory of a timer, and may have none now.
constexpr int kTries = 100;

std::uint64_t load(const __u64& word) { return __atomic_load_n(&word, __ATOMIC_RELAXED); }

std::uint64_t per_1000_seconds(std::uint64_t events, std::uint64_t ns) {
  return static_cast<std::uint64_t>(static_cast<double>(events) * 1e12 / static_cast<double>(ns) +
                                    0.5);
}

/// Programs that have to do with timers give 0 or a negative errno, as does this.
int run(int program, std::uint32_t mark) {
  std::array<std::uint8_t, 14> frame{};  // the least that a test run takes; not looked at
  __sk_buff context{};
  context.mark = mark;
  LIBBPF_OPTS(bpf_test_run_opts, run);
  run.data_in = frame.data();
  run.data_size_in = frame.size();
  run.ctx_in = &context;
  run.ctx_size_in = sizeof(context);
  const int error = bpf_prog_test_run_opts(program, &run);
  return error != 0 ? error : static_cast<int>(run.retval);
}

int share_maps(watch_bpf& object, const WatchedMaps& maps, const Fd& timers) {
  int error = bpf_map__reuse_fd(object.maps.bss, maps.table);
  if (error == 0) error = bpf_map__reuse_fd(object.maps.data_control, maps.control);
  if (error == 0) error = bpf_map__reuse_fd(object.maps.events, maps.events);
  if (error == 0 && timers) error = bpf_map__reuse_fd(object.maps.watchmen, timers.get());
  return error;
}

}  // namespace

void destroy_watchmen(watch_bpf* object) { watch_bpf__destroy(object); }

Result<Watchmen> Watchmen::load(std::uint32_t ifindex, const WatchedMaps& maps,
                                const std::string& pin_path) {
  const Complaints complaints;
  Object object(watch_bpf__open());
  if (!object) return complaints.error("open the timers of a gate", errno);
  object->rodata->ifindex = ifindex;
  const Fd timers = open_pin(pin_path);
  if (const int error = share_maps(*object, maps, timers); error != 0)
    return complaints.error("prepare the timers of a gate", error);
  if (const int error = watch_bpf__load(object.get()); error != 0)
    return complaints.error("load the timers of a gate", error);
  if (!timers)
    if (auto pinned = pin(bpf_map__fd(object->maps.watchmen), pin_path); !pinned)
      return std::unexpected(pinned.error());
  int made = run(bpf_program__fd(object->progs.watch_make), 0);
  for (int i = 0; made == -ENOMEM && i < kTries; ++i) {
    ::poll(nullptr, 0, 1);
    made = run(bpf_program__fd(object->progs.watch_make), 0);
  }
  if (made != 0) return failure("make the timers of a gate", made);
  return Watchmen(std::move(object));
}

Result<void> Watchmen::arm(std::uint16_t slot) const {
  if (const int error = run(bpf_program__fd(object_->progs.watch_arm), slot); error != 0)
    return failure("start a timer", error);
  return {};
}

Arrivals arrivals(const gate_watch& watch, std::uint64_t now) {
  Arrivals out;
  const std::uint64_t period = load(watch.period);
  const std::uint64_t last = load(watch.last);
  const std::uint64_t begin = last != 0 ? last : load(watch.since);
  for (std::size_t i = 0; i < GATE_GAPS; ++i) {
    out.gaps[i] = load(watch.gaps[i]);
    out.events += out.gaps[i];
  }
  if (last != 0) ++out.events;
  out.since_last = begin != 0 && now > begin ? now - begin : 0;
  const std::uint64_t first = load(watch.first);
  if (out.events > 1 && last > first) out.rate = per_1000_seconds(out.events - 1, last - first);
  out.silent = load(watch.silent) != 0 && load(watch.silence) != 0;
  out.missing = load(watch.missing);
  // As between two events half a period late is missing; once silence is too long no more is late.
  if (last != 0 && period != 0 && out.since_last > period)
    out.missing +=
        out.silent ? out.since_last / period : (out.since_last + period / 2) / period - 1;
  out.last_gap = load(watch.last_gap);
  out.shortest = load(watch.shortest);
  out.longest = load(watch.longest);
  out.jitter = load(watch.deviation);
  return out;
}

}  // namespace mlcca::enforce
