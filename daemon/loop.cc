// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/loop.hpp"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <systemd/sd-daemon.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <string>

#include "base/at_once.hpp"

namespace mlcca {
namespace {

constexpr std::uint64_t kRoundInterval = 1'000'000;  // µs
constexpr std::uint64_t kAccuracy = 10'000;          // µs

std::uint64_t beat_micros(const Controller& gateway) { return gateway.beat_interval() / 1000; }

}  // namespace

EventLoop new_event_loop() {
  sd_event* raw = nullptr;
  sd_event_new(&raw);
  return EventLoop(raw);
}

Result<Loop> Loop::open(sd_event* raw, Controller& gateway, const RealOutside& outside) {
  auto sources = std::make_unique<Sources>(raw, gateway);
  Sources* const s = sources.get();
  int e = 0;
  // The signals must be blocked before their sources are added.
  sigset_t handled;
  sigemptyset(&handled);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&handled, signal);
  ::sigprocmask(SIG_BLOCK, &handled, nullptr);
  if (e >= 0) e = sd_event_add_signal(raw, nullptr, SIGTERM, on_end, s);
  if (e >= 0) e = sd_event_add_signal(raw, nullptr, SIGINT, on_end, s);
  if (e >= 0) e = sd_event_add_signal(raw, nullptr, SIGHUP, on_hangup, s);
  if (e >= 0) e = sd_event_add_io(raw, nullptr, outside.links_fd(), EPOLLIN, on_links, s);
  if (e >= 0) e = sd_event_add_io(raw, nullptr, outside.reports_fd(), EPOLLIN, on_events, s);
  // The heart-beat has priority over requests of clients.
  sd_event_source* beat = nullptr;
  if (e >= 0) e = sd_event_add_time_relative(raw, &beat, CLOCK_MONOTONIC, 0, kAccuracy, on_beat, s);
  if (e >= 0) e = sd_event_source_set_priority(beat, SD_EVENT_PRIORITY_IMPORTANT);
  if (e >= 0) e = sd_event_source_set_floating(beat, 1);
  sd_event_source_unref(beat);
  if (e >= 0)
    e = sd_event_add_time_relative(raw, nullptr, CLOCK_MONOTONIC, kRoundInterval, kAccuracy,
                                   on_round, s);
  s->always = Fd(::eventfd(1, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!s->always) e = -errno;
  sd_event_source* work = nullptr;
  if (e >= 0) e = sd_event_add_io(raw, &work, s->always.get(), EPOLLIN, on_work, s);
  s->work.reset(work);
  if (e >= 0) e = sd_event_source_set_enabled(work, SD_EVENT_OFF);
  sd_event_source* due = nullptr;
  if (e >= 0) e = sd_event_add_time(raw, &due, CLOCK_MONOTONIC, 0, kAccuracy, on_due, s);
  s->due.reset(due);
  if (e >= 0) e = sd_event_source_set_enabled(due, SD_EVENT_OFF);
  if (e >= 0) e = sd_event_add_post(raw, nullptr, after_turn, s);
  // sd_event_set_watchdog() is not used, because it waits if no process reads the socket of the
  // service manager.
  if (e >= 0 && sd_watchdog_enabled(0, &s->watchdog) > 0) {
    s->watchdog /= 2;
    e = sd_event_add_time_relative(raw, nullptr, CLOCK_MONOTONIC, 0, kAccuracy, on_watchdog, s);
  }
  if (e < 0)
    return fail(std::string("event loop: ") + std::strerror(-e));  // NOLINT(concurrency-mt-unsafe)

  // Without udev (in a container, or in early boot) interfaces are still identified by names and
  // aliases.
  sd_device_monitor* monitor = nullptr;
  if (sd_device_monitor_new(&monitor) >= 0) {
    s->udev.reset(monitor);
    sd_device_monitor_filter_add_match_subsystem_devtype(monitor, "net", nullptr);
    sd_device_monitor_attach_event(monitor, raw);
    sd_device_monitor_start(monitor, on_udev, s);
  }
  return Loop(std::move(sources));
}

void Loop::Sources::notify_manager() {
  const std::string status = "STATUS=" + gateway.summary();
  if (notify(ready_sent ? status : "READY=1\n" + status)) ready_sent = true;
}

int Loop::run() const {
  sources_->notify_manager();
  return sd_event_loop(sources_->event) < 0 ? 1 : 0;
}

int Loop::on_watchdog(sd_event_source* source, std::uint64_t, void* self) noexcept {
  notify("WATCHDOG=1");
  sd_event_source_set_time_relative(source, static_cast<Sources*>(self)->watchdog);
  sd_event_source_set_enabled(source, SD_EVENT_ONESHOT);
  return 0;
}

int Loop::on_links(sd_event_source*, int, std::uint32_t, void* self) noexcept {
  static_cast<Sources*>(self)->links_dirty = true;
  // The notifications are read from the socket after the turn. Until then it stays readable; that
  // does no harm, because the turn ends with this handler.
  return 0;
}

int Loop::on_events(sd_event_source*, int, std::uint32_t, void* self) noexcept {
  static_cast<Sources*>(self)->gateway.gates_reported();
  return 0;
}

int Loop::on_udev(sd_device_monitor*, sd_device*, void* self) noexcept {
  static_cast<Sources*>(self)->identities_dirty = true;
  return 0;
}

int Loop::on_beat(sd_event_source* source, std::uint64_t, void* self) noexcept {
  auto& s = *static_cast<Sources*>(self);
  s.gateway.beat();
  sd_event_source_set_time_relative(source, beat_micros(s.gateway));
  sd_event_source_set_enabled(source, SD_EVENT_ONESHOT);
  return 0;
}

int Loop::on_round(sd_event_source* source, std::uint64_t, void* self) noexcept {
  auto& s = *static_cast<Sources*>(self);
  s.gateway.begin_round();
  sd_event_source_set_enabled(s.work.get(), SD_EVENT_ON);
  s.notify_manager();
  sd_event_source_set_time_relative(source, kRoundInterval);
  sd_event_source_set_enabled(source, SD_EVENT_ONESHOT);
  return 0;
}

int Loop::on_work(sd_event_source* source, int, std::uint32_t, void* self) noexcept {
  auto& s = *static_cast<Sources*>(self);
  s.gateway.work();
  if (!s.gateway.has_work()) sd_event_source_set_enabled(source, SD_EVENT_OFF);
  return 0;
}

/// Ends at once, or when what is reserved has been given back. A second signal does not wait for
/// that.
int Loop::on_end(sd_event_source*, const signalfd_siginfo*, void* self) noexcept {
  auto& s = *static_cast<Sources*>(self);
  if (std::exchange(s.ends, true) || s.gateway.begin_stop()) sd_event_exit(s.event, 0);
  return 0;
}

int Loop::on_hangup(sd_event_source*, const signalfd_siginfo*, void* self) noexcept {
  static_cast<Sources*>(self)->gateway.reload();
  return 0;
}

int Loop::after_turn(sd_event_source*, void* self) noexcept {
  auto& s = *static_cast<Sources*>(self);
  if (std::exchange(s.links_dirty, false)) s.gateway.links_changed();
  if (std::exchange(s.identities_dirty, false)) s.gateway.identities_changed();
  s.gateway.act();
  if (const auto due = s.gateway.due()) {
    constexpr std::uint64_t in_a_micro = 1000;
    sd_event_source_set_time(s.due.get(), *due / in_a_micro + 1);
    sd_event_source_set_enabled(s.due.get(), SD_EVENT_ONESHOT);
  }
  if (s.ends && s.gateway.may_stop()) sd_event_exit(s.event, 0);
  return 0;
}

}  // namespace mlcca
