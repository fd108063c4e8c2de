// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/silence_timers.hpp"

#include <bpf/bpf.h>
#include <bpf/libbpf.h>
#include <ether_watch.skel.h>
#include <fcntl.h>
#include <poll.h>
#include <watch.skel.h>

#include <array>
#include <cerrno>
#include <memory>
#include <utility>

#include "daemon/gates/complaints.hpp"
#include "daemon/gates/failure.hpp"
#include "daemon/gates/pins.hpp"

namespace mlcca::gates {
namespace {

/// The attempts are milliseconds apart: the kernel takes no lock for the memory of a timer, and may
/// have none at this moment.
constexpr int kTries = 100;

/// Runs a program of the timers. Programs and this function return 0 or a negative errno.
int run(int program, std::uint32_t mark) {
  std::array<std::uint8_t, 14> frame{};  // the smallest frame that a test run takes; not read
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

int share_maps(const watch_bpf& object, const WatchedMaps& maps) {
  return bpf_map__reuse_fd(object.maps.bss, maps.table);
}

int share_maps(const ether_watch_bpf& object, const WatchedMaps& maps) {
  int error = bpf_map__reuse_fd(object.maps.bss, maps.table);
  if (error == 0) error = bpf_map__reuse_fd(object.maps.slots, maps.slots);
  if (error == 0) error = bpf_map__reuse_fd(object.maps.watches, maps.watches);
  return error;
}

template <class Skeleton>
int share_all(const Skeleton& object, const WatchedMaps& maps, const Fd& timers) {
  int error = share_maps(object, maps);
  if (error == 0) error = bpf_map__reuse_fd(object.maps.data_control, maps.control);
  if (error == 0) error = bpf_map__reuse_fd(object.maps.events, maps.events);
  if (error == 0 && timers) error = bpf_map__reuse_fd(object.maps.silence_timers, timers.get());
  return error;
}

}  // namespace

template <class Skeleton>
Result<SilenceTimers> SilenceTimers::load(std::uint32_t ifindex, const WatchedMaps& maps,
                                          const std::string& pin_path, bool take_over) {
  const Complaints complaints;
  const std::unique_ptr<Skeleton, decltype(&Skeleton::destroy)> object(Skeleton::open(),
                                                                       &Skeleton::destroy);
  if (!object) return complaints.error("open the timers of a gate", errno);
  object->rodata->ifindex = ifindex;
  const Fd timers = take_over ? open_pin(pin_path) : Fd();
  const auto failed = [&](const char* what, int error) -> Result<SilenceTimers> {
    // What is pinned there may not be timers of ours; then new ones are made.
    if (timers)
      if (auto fresh = load<Skeleton>(ifindex, maps, pin_path, false)) return fresh;
    return complaints.error(what, error);
  };
  if (const int error = share_all(*object, maps, timers); error != 0)
    return failed("prepare the timers of a gate", error);
  if (const int error = Skeleton::load(object.get()); error != 0)
    return failed("load the timers of a gate", error);
  int made = run(bpf_program__fd(object->progs.watch_make), 0);
  for (int i = 0; made == -ENOMEM && i < kTries; ++i) {
    ::poll(nullptr, 0, 1);
    made = run(bpf_program__fd(object->progs.watch_make), 0);
  }
  if (made != 0) return failure("make the timers of a gate", made);
  Fd arm(::fcntl(bpf_program__fd(object->progs.watch_arm), F_DUPFD_CLOEXEC, 0));
  Fd kept(::fcntl(bpf_map__fd(object->maps.silence_timers), F_DUPFD_CLOEXEC, 0));
  if (!arm || !kept) return failure("keep the timers of a gate", errno);
  return SilenceTimers(std::move(arm), std::move(kept), pin_path);
}

Result<SilenceTimers> SilenceTimers::of_can(std::uint32_t ifindex, const WatchedMaps& maps,
                                            const std::string& pin_path, bool take_over) {
  return load<watch_bpf>(ifindex, maps, pin_path, take_over);
}

Result<SilenceTimers> SilenceTimers::of_ethernet(std::uint32_t ifindex, const WatchedMaps& maps,
                                                 const std::string& pin_path, bool take_over) {
  return load<ether_watch_bpf>(ifindex, maps, pin_path, take_over);
}

Result<void> SilenceTimers::arm(std::uint32_t watch) const {
  if (const int error = run(program_.get(), watch); error != 0)
    return failure("start a timer", error);
  return {};
}

}  // namespace mlcca::gates
