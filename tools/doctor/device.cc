// SPDX-License-Identifier: BSD-2-Clause
#include "tools/doctor/device.hpp"

#include <fmt/format.h>
#include <linux/can/netlink.h>

#include <array>

namespace mlcca::doctor {
namespace {

struct Mode {
  std::uint32_t flag;
  const char* name;
  const char* harm;  ///< nullptr: it does no harm
};
constexpr const char* kGateDrops =
    "the gate of mlccad drops the probe frames: mlccactl mode audit lets them pass, mlccactl mode "
    "enforce closes it again";

constexpr std::array kModes = {
    Mode{CAN_CTRLMODE_LOOPBACK, "loopback", "frames do not reach the bus"},
    Mode{CAN_CTRLMODE_LISTENONLY, "listen-only", "it neither sends nor acknowledges"},
    Mode{CAN_CTRLMODE_ONE_SHOT, "one-shot", "a frame that loses arbitration is not sent again"},
    Mode{CAN_CTRLMODE_PRESUME_ACK, "presume-ack", "a frame that no node received counts as sent"},
    Mode{CAN_CTRLMODE_FD_NON_ISO, "fd-non-iso", "nodes of ISO 11898-1:2015 do not understand it"},
    Mode{CAN_CTRLMODE_FD, "fd", nullptr},
    Mode{CAN_CTRLMODE_3_SAMPLES, "triple-sampling", nullptr},
    Mode{CAN_CTRLMODE_BERR_REPORTING, "berr-reporting", nullptr},
};

std::string sample_point(std::uint32_t of_1000) {
  return of_1000 == 0 ? "sample point not said" : fmt::format("sample point {} %", of_1000 / 10.0);
}

Line judge_device(const Device& device) {
  const auto& kind = device.link.kind;
  return {
      "device", Outcome::ok,
      fmt::format("{}: driver {}, kind {}{}", device.link.name,
                  device.controller.driver.empty() ? "not said" : device.controller.driver,
                  kind.empty() ? "not said" : kind, is_virtual(device) ? ", a virtual bus" : "")};
}

Line judge_modes(const Device& device) {
  if (is_virtual(device)) return {"modes", Outcome::not_tested, "a virtual bus has no controller"};
  std::string names;
  std::string harm;
  for (const Mode& mode : kModes) {
    if ((device.controller.modes & mode.flag) == 0) continue;
    names += names.empty() ? mode.name : fmt::format(", {}", mode.name);
    if (mode.harm != nullptr)
      harm += fmt::format("{}{}: {}", harm.empty() ? "" : "; ", mode.name, mode.harm);
  }
  if (!harm.empty())
    return {"modes", Outcome::failed,
            fmt::format("{} (ip link set {} type can MODE off)", harm, device.link.name)};
  return {"modes", Outcome::ok, names.empty() ? "classic, none of the special ones" : names};
}

Line judge_state(const Device& device) {
  if (device.link.can_state.empty())
    return {"state", Outcome::not_tested,
            is_virtual(device) ? "a virtual bus has none" : "the driver does not say"};
  if (!device.link.up)
    return {"state", Outcome::not_tested,
            fmt::format("{0} is down: ip link set {0} up", device.link.name)};
  const auto& errors = device.controller.errors;
  const bool good = device.link.can_state == "error-active";
  return {
      "state", good ? Outcome::ok : Outcome::failed,
      device.link.can_state + (errors ? fmt::format(", error counters: sending {}, receiving {}",
                                                    errors->sending, errors->receiving)
                                      : ", the driver has no error counters")};
}

Line judge_restart(const Device& device) {
  if (is_virtual(device)) return {"restart", Outcome::not_tested, "a virtual bus has no bus-off"};
  if (const auto ms = device.controller.restart_ms; ms != 0)
    return {"restart", Outcome::ok,
            fmt::format("WARNING: {0} ms after a bus-off it restarts by itself, which hides the "
                        "bus-off: ip link set {1} type can restart-ms 0",
                        ms, device.link.name)};
  return {"restart", Outcome::ok, "none by itself (restart-ms 0): a bus-off stays and is reported"};
}

Line judge_clock(const Device& device) {
  if (device.controller.clock == 0)
    return {"clock", Outcome::not_tested,
            is_virtual(device) ? "a virtual bus has none" : "the driver does not say"};
  return {"clock", Outcome::ok, fmt::format("{} MHz", device.controller.clock / 1e6)};
}

Line judge_queue(const Device& device) {
  const auto& c = device.controller;
  if (c.queue.empty() || c.queue == "noqueue" || c.queue == "noop")
    return {"queue", Outcome::ok, fmt::format("none, txqueuelen {}", c.queue_length)};
  return {"queue", Outcome::ok, fmt::format("{}, txqueuelen {}", c.queue, c.queue_length)};
}

Line judge_gate(const Device& device) {
  switch (device.gate) {
    case Gate::none:
      return {"gate", Outcome::ok, "none of mlccad, probe frames pass"};
    case Gate::audit:
      return {"gate", Outcome::ok, "that of mlccad is there, in audit mode: probe frames pass"};
    case Gate::enforcing:
      return {"gate", Outcome::not_tested, kGateDrops};
    case Gate::unknown:
      break;
  }
  return {"gate", Outcome::not_tested, device.gate_error + "; root can read it"};
}

Line judge_bitrate(const Device& device) {
  const auto& link = device.link;
  if (is_virtual(device))
    return {"bit rate", Outcome::not_tested,
            "a virtual bus has none: its description says it (Bus bitrate)"};
  if (link.bitrate == 0)
    return {"bit rate", Outcome::failed,
            fmt::format("none, so mlccad grants nothing over it: ip link set {} type can bitrate "
                        "500000, or whatever the bus has",
                        link.name)};
  std::string text =
      fmt::format("{} bit/s, {}", link.bitrate, sample_point(device.controller.sample_point));
  if (link.data_bitrate != 0)
    text += fmt::format("; data phase {} bit/s, {}", link.data_bitrate,
                        sample_point(device.controller.data_sample_point));
  if (device.controller.fd && link.data_bitrate < link.bitrate)
    return {"bit rate", Outcome::failed, text + "; takes FD frames without a data bit rate"};
  return {"bit rate", Outcome::ok, text};
}

}  // namespace

bool is_virtual(const Device& device) {
  return device.link.kind == "vcan" || device.link.kind == "vxcan";
}

core::can::Timing timing_of(const Device& device) {
  return {.bitrate = device.link.bitrate, .data_bitrate = device.link.data_bitrate};
}

std::vector<Line> judge(const Device& device) {
  return {judge_device(device), judge_modes(device), judge_state(device), judge_restart(device),
          judge_clock(device),  judge_queue(device), judge_gate(device),  judge_bitrate(device)};
}

std::optional<std::string> why_not_send(const Device& device, bool may_send) {
  const auto& link = device.link;
  if (!may_send) return "needs --send, which sends frames on the bus";
  if (!link.up) return fmt::format("{0} is down: ip link set {0} up", link.name);
  if (!link.running && link.can_state != "bus-off") return link.name + " has no carrier";
  if (device.gate == Gate::enforcing)
    return "the gate of mlccad drops the probe frames: mlccactl mode audit lets them pass, "
           "mlccactl "
           "mode enforce closes it again";
  if (is_virtual(device)) return {};
  if (link.bitrate == 0) return "without a bit rate nothing is sent";
  if ((device.controller.modes & CAN_CTRLMODE_LISTENONLY) != 0)
    return "a listen-only controller sends nothing";
  if (link.can_state == "bus-off")
    return fmt::format("it is bus-off: ip link set {0} down, then up", link.name);
  return {};
}

}  // namespace mlcca::doctor
