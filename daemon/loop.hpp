// SPDX-License-Identifier: BSD-2-Clause
// The only event loop: signals, interfaces, udev, timers. Handlers only mark what has changed; a
// post handler acts once a turn.
#pragma once
#include <systemd/sd-device.h>
#include <systemd/sd-event.h>

#include <cstdint>
#include <memory>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "daemon/gateway/controller.hpp"
#include "daemon/real_outside.hpp"

namespace mlcca {

using EventLoop = std::unique_ptr<sd_event, FreeWith<sd_event_unref>>;
/// nullptr if there is no memory.
[[nodiscard]] EventLoop new_event_loop();

/// The event sources of the gateway on the loop.
class Loop {
 public:
  /// Adds the sources of the gateway to `raw`, which must outlive this object.
  static Result<Loop> open(sd_event* raw, Controller& gateway, const RealOutside& outside);

  /// Runs until SIGTERM or SIGINT. Returns the exit status of the program.
  [[nodiscard]] int run() const;

 private:
  using Source = std::unique_ptr<sd_event_source, FreeWith<sd_event_source_unref>>;
  struct Sources {
    Sources(sd_event* e, Controller& g) : event(e), gateway(g) {}
    /// Reports the state of the gateway to the service manager, including READY=1 until the manager
    /// has taken it.
    void notify_manager();
    sd_event* event;
    Controller& gateway;
    bool links_dirty = false;
    bool identities_dirty = false;
    bool ready_sent = false;
    bool ends = false;           ///< it was asked to end
    std::uint64_t watchdog = 0;  ///< µs between the signs of life for the service manager; 0: none
    Fd always;                   ///< always readable: queues behind the sockets of clients
    Source work;  ///< the event source of always: does a part of a round in each turn
    Source due;   ///< the timer of Controller::due(); its handler does nothing but begin a turn
    std::unique_ptr<sd_device_monitor, FreeWith<sd_device_monitor_unref>> udev;
  };
  explicit Loop(std::unique_ptr<Sources> sources) : sources_(std::move(sources)) {}
  static int on_links(sd_event_source*, int, std::uint32_t, void* self) noexcept;
  static int on_events(sd_event_source*, int, std::uint32_t, void* self) noexcept;
  static int on_udev(sd_device_monitor*, sd_device*, void* self) noexcept;
  static int on_beat(sd_event_source* source, std::uint64_t now, void* self) noexcept;
  static int on_round(sd_event_source* source, std::uint64_t now, void* self) noexcept;
  static int on_work(sd_event_source*, int, std::uint32_t, void* self) noexcept;
  static int on_due(sd_event_source*, std::uint64_t, void*) noexcept { return 0; }
  static int on_watchdog(sd_event_source* source, std::uint64_t now, void* self) noexcept;
  static int on_end(sd_event_source*, const signalfd_siginfo*, void* self) noexcept;
  static int on_hangup(sd_event_source*, const signalfd_siginfo*, void* self) noexcept;
  static int after_turn(sd_event_source*, void* self) noexcept;

  std::unique_ptr<Sources> sources_;
};

}  // namespace mlcca
