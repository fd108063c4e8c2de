// SPDX-License-Identifier: BSD-2-Clause
#include <linux/can/error.h>
#include <poll.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "base/clock.hpp"
#include "daemon/net/links.hpp"
#include "tools/doctor/measure.hpp"

namespace mlcca::doctor {
namespace {

/// A controller detects a short circuit only while it sends.
constexpr int kSendEveryMs = 100;

bool is_bus_off(const net::Links& links, int ifindex) {
  const auto link = links.table().find(ifindex);
  return link != links.table().end() && link->second.can_state == "bus-off";
}

/// Whether the controller runs and takes part in the bus.
bool is_on_bus(const net::Links& links, int ifindex) {
  const auto link = links.table().find(ifindex);
  return link != links.table().end() && link->second.running && !is_bus_off(links, ifindex) &&
         link->second.can_state.starts_with("error-");
}

Result<void> take_frames(const Probe& probe, BusOff& seen) {
  for (;;) {
    const auto frame = probe.next(0);
    if (!frame) return std::unexpected(frame.error());
    if (!*frame) return {};
    if (((*frame)->error & CAN_ERR_BUSOFF) != 0 && !seen.frame_ns) seen.frame_ns = (*frame)->ns;
  }
}

}  // namespace

Result<BusOff> await_bus_off(const Probe& probe, int ifindex, unsigned seconds) {
  auto links = net::Links::open();
  if (!links) return std::unexpected(links.error());
  BusOff seen;
  seen.seconds = seconds;
  const auto patience = std::uint64_t{seconds} * 1'000'000'000;
  auto end = monotonic_ns() + patience;
  std::uint32_t number = 0;
  while (monotonic_ns() < end) {
    // A frame that cannot be sent does not matter: on a shorted bus none can.
    if (!seen.frame_ns && !seen.link_ns) static_cast<void>(probe.send(number++, false));
    std::array ready{pollfd{.fd = probe.fd(), .events = POLLIN, .revents = 0},
                     pollfd{.fd = links->fd(), .events = POLLIN, .revents = 0}};
    if (::poll(ready.data(), ready.size(), kSendEveryMs) < 0 && errno != EINTR)
      return fail(std::string("poll: ") + std::strerror(errno));  // NOLINT(concurrency-mt-unsafe)
    if (auto taken = take_frames(probe, seen); !taken) return std::unexpected(taken.error());
    if (const auto changed = links->refresh(); !changed) return std::unexpected(changed.error());
    if (!seen.link_ns && is_bus_off(*links, ifindex)) {
      seen.link_ns = unix_ns();
      end = monotonic_ns() + patience;
    }
    if (seen.link_ns && is_on_bus(*links, ifindex)) {
      seen.recovered_ns = unix_ns();
      break;
    }
  }
  return seen;
}

}  // namespace mlcca::doctor
