// SPDX-License-Identifier: BSD-2-Clause
// The request `status`: the gateway, its interfaces, and what is wrong.
#include "control/version.hpp"
#include "daemon/gateway/delivery_health.hpp"
#include "daemon/gateway/health_report.hpp"
#include "daemon/gateway/modes.hpp"
#include "daemon/gateway/reloads.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/options.hpp"
#include "daemon/outside/gate_control.hpp"
#include "daemon/outside/gate_driver.hpp"

namespace mlcca::requests {
namespace {

constexpr std::size_t kManyPorts = 16;

control::Status status_of(const StatusParts& c) {
  control::Status s;
  s.version = kVersion;
  s.gateway = c.scene.state->system().gateways[c.scene.self].name;
  s.system = c.scene.state->system().name;
  s.description_file = c.options.description;
  s.mode = c.modes.name();
  s.when_clean_ns = c.modes.when_clean();
  s.clean_ns = c.modes.clean();
  s.audit_until_enforced = c.modes.is_introduction();
  s.open = c.control.is_open() && !c.control.lapsed();
  s.grace_ns = c.control.grace();
  s.lapses = c.control.lapses();
  s.channels_granted = static_cast<std::uint32_t>(c.scene.state->granted());
  s.channels_refused = static_cast<std::uint32_t>(c.scene.state->refused());
  s.started_unix_s = c.started;
  s.loaded_unix_s = c.reloads.loaded();
  s.reload_error = c.reloads.last_error();
  if (const auto problems = c.health.problems(); !problems.empty()) s.problem = problems.front();
  s.interfaces = c.gates.report();
  for (control::Interface& interface : s.interfaces)
    for (control::Unknown& frame : interface.unknown)
      if (const auto channel = c.scene.state->channel_of(frame.subject);
          frame.subject != 0 && channel)
        frame.channel = c.scene.state->system().channels[*channel].name;
  s.health = c.health.health(s.interfaces);
  return s;
}

}  // namespace

Response status(const StatusParts& parts, const Asker& asker,
                const control::StatusRequest& /*request*/) {
  return parts.replies.made(asker,
                            parts.gates.size() > kManyPorts || parts.delivery_health.is_large(),
                            [parts] { return status_of(parts); });
}

}  // namespace mlcca::requests
