// SPDX-License-Identifier: BSD-2-Clause
#include "tools/doctor/examine.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <iterator>
#include <span>
#include <utility>

#include "bpf/gate.h"
#include "daemon/gates/readback.hpp"
#include "daemon/net/filter_order.hpp"
#include "tools/doctor/device.hpp"
#include "tools/doctor/measure.hpp"

namespace mlcca::doctor {
namespace {

constexpr unsigned kSingles = 10;
constexpr unsigned kFillings = 3;

/// Determines the gate: whether there is one from the attached filters, whether it drops from what
/// the daemon has pinned.
void take_gate(const std::string& root, Device& device) {
  const auto ifindex = device.link.ifindex;
  const auto filters = net::all_filters(ifindex, /*ingress=*/false);
  const bool hangs = filters && std::ranges::any_of(*filters, [](const net::Filter& f) {
                       return f.priority == GATE_TC_PRIORITY && f.handle == GATE_TC_HANDLE;
                     });
  device.gate = hangs ? Gate::enforcing : Gate::none;
  if (::access(root.c_str(), F_OK) != 0 && errno == ENOENT) return;
  const auto pinned = gates::read_back(root);
  if (!pinned && !hangs) {
    device.gate = Gate::unknown;
    device.gate_error = pinned.error().text;
  }
  if (!pinned) return;
  const bool ours = std::ranges::any_of(pinned->gates, [&](const gates::GateReading& gate) {
    return static_cast<int>(gate.ifindex) == ifindex;
  });
  if (ours) device.gate = pinned->audit ? Gate::audit : Gate::enforcing;
}

/// The entry of a CAN interface.
Result<net::InterfaceTable::const_iterator> entry_of(const net::Links& links,
                                                     const std::string& interface) {
  const auto at = std::ranges::find(links.table(), interface,
                                    [](const auto& entry) { return entry.second.name; });
  if (at == links.table().end()) return fail(interface + ": there is no such interface");
  if (!at->second.is_can) return fail(interface + ": is no CAN interface");
  return at;
}

Result<Device> read_device(const Request& request) {
  const auto links = net::Links::open();
  if (!links) return std::unexpected(links.error());
  const auto found = entry_of(*links, request.interface);
  if (!found) return std::unexpected(found.error());
  const auto at = *found;
  auto controller = net::read_controller(at->first);
  if (!controller) return std::unexpected(controller.error());
  Device device{.link = at->second, .controller = std::move(*controller), .gate_error = {}};
  take_gate(request.bpf_root, device);
  return device;
}

using Say = std::function<void(const std::string&)>;

/// The checks that send frames, in their order.
constexpr std::array kSendingChecks = {"echo",        "bit rate measured", "data rate measured",
                                       "queue depth", "error counters",    "bus-off"};

std::vector<Line> not_tested(std::span<const char* const> checks, const std::string& why) {
  std::vector<Line> lines;
  for (const char* check : checks) lines.push_back({check, Outcome::not_tested, why});
  return lines;
}

Line rate(const Device& device, const Probe& probe, bool data) {
  const char* name = data ? "data rate measured" : "bit rate measured";
  if (auto why = why_no_rate(device, data)) return {name, Outcome::not_tested, std::move(*why)};
  const auto count = frames_for_passage(probe, timing_of(device), data);
  const auto passage = send_back_to_back(probe, count, data);
  if (!passage) return {name, Outcome::failed, passage.error().text};
  return judge_rate(device, *passage, data);
}

Line depth(const Device& device, const Probe& probe, std::optional<unsigned> described) {
  if (auto why = why_no_depth(device)) return {"queue depth", Outcome::not_tested, std::move(*why)};
  std::vector<Filling> fillings;
  for (unsigned i = 0; i < kFillings; ++i) {
    const auto filling = fill(probe, device.controller.queue_limit);
    if (!filling) return {"queue depth", Outcome::failed, filling.error().text};
    fillings.push_back(*filling);
  }
  return judge_depth(device, fillings, described);
}

Line counted_errors(const Device& device) {
  const auto after = net::read_controller(device.link.ifindex);
  if (!after) return {"error counters", Outcome::failed, after.error().text};
  return judge_counters(device.controller.errors, after->errors);
}

Line bus_off(const Device& device, const Probe& probe, unsigned seconds, const Say& say) {
  if (is_virtual(device)) return {"bus-off", Outcome::not_tested, "a virtual bus has none"};
  if (seconds == 0)
    return {"bus-off", Outcome::not_tested,
            "no program can make one: --bus-off 60 waits while you short CAN_H and CAN_L"};
  say(
      fmt::format("short CAN_H and CAN_L of {0} within {1} s; then open them and restart it (ip "
                  "link set {0} type can restart, or down and up) within {1} s",
                  device.link.name, seconds));
  const auto seen = await_bus_off(probe, device.link.ifindex, seconds);
  if (!seen) return {"bus-off", Outcome::failed, seen.error().text};
  return judge_bus_off(*seen);
}

/// Makes the checks that send: a line for the echo and one for each further check.
std::vector<Line> send(const Device& device, const Request& request, const Say& say) {
  const auto behind_echo = std::span(kSendingChecks).subspan(1);
  const auto given_up = [&](const Line& echo, const std::string& why) {
    auto lines = not_tested(behind_echo, why);
    lines.insert(lines.begin(), echo);
    return lines;
  };
  if (const auto why = why_not_send(device, request.send)) return not_tested(kSendingChecks, *why);
  const auto probe = Probe::open(device.link.ifindex, request.id, device.controller.fd);
  if (!probe)
    return given_up({"echo", Outcome::failed, probe.error().text}, "there is no CAN socket");
  say(fmt::format(
      "sends frames {:0{}X} on {}, for about half a second as fast as the bus takes them",
      request.id.value, request.id.extended ? 8 : 3, device.link.name));
  const auto singles = send_singly(*probe, kSingles);
  if (!singles)
    return given_up({"echo", Outcome::failed, singles.error().text}, "no frame can be sent");
  const auto echo = judge_echo(device, *singles);
  if (std::ranges::any_of(*singles, [](const Single& s) { return s.echoes_ns.empty(); }))
    return given_up(echo, "sent frames do not come back");
  // Initialiser lists are evaluated in order.
  return {echo,
          rate(device, *probe, false),
          rate(device, *probe, true),
          depth(device, *probe, request.fifo_depth),
          counted_errors(device),
          bus_off(device, *probe, request.bus_off_seconds, say)};
}

}  // namespace

std::optional<std::string> why_no_controller(const std::string& interface) {
  const auto links = net::Links::open();
  if (!links) return std::nullopt;
  const auto found = entry_of(*links, interface);
  return found ? std::nullopt : std::optional(found.error().text);
}

Result<std::vector<Line>> examine(const Request& request, const Say& say) {
  const auto device = read_device(request);
  if (!device) return std::unexpected(device.error());
  auto lines = judge(*device);
  std::ranges::move(send(*device, request, say), std::back_inserter(lines));
  return lines;
}

}  // namespace mlcca::doctor
