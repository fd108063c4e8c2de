// SPDX-License-Identifier: BSD-2-Clause
// The parts of a gateway that requests are answered with.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "daemon/gateway/aside.hpp"
#include "daemon/gateway/requests/asked.hpp"
#include "daemon/gateway/requests/response.hpp"
#include "daemon/gateway/scene.hpp"

namespace mlcca {

struct Options;
class Admissions;
class AuditKeeper;
class AuditLog;
class CanForwarding;
class Carriers;
class ChannelReports;
class DeliveryEvents;
class DeliveryHealth;
class DropReports;
class Endpoints;
class EventLog;
class GateControl;
class GateDriver;
class GateEvents;
class GatewayPresence;
class HealthReport;
class LocalEnds;
class Membership;
class Meshes;
class Modes;
class Patience;
class Recorder;
class Reloads;
class TagBindings;
class Turn;
namespace store {
class History;
}

/// All of it outlives every request, and every slice of a reply.
struct Context {
  const Options& options;
  const Clock& clock;
  GateDriver& gates;
  GateControl& control;
  Scene& scene;
  EventLog& log;
  DeliveryEvents& deliveries;
  Turn& turn;
  Recorder& recorder;
  Admissions& admissions;
  TagBindings& tags;
  GateEvents& gate_events;
  const AuditLog& audit;
  AuditKeeper& audit_keeper;
  Modes& modes;
  DeliveryHealth& delivery_health;
  HealthReport& health;
  ChannelReports& channels;
  Endpoints& endpoints;
  Carriers& carriers;
  GatewayPresence& presence;
  LocalEnds& local_ends;
  CanForwarding& forwarding;
  Meshes& meshes;
  Reloads& reloads;
  Aside& aside;
  Patience& patience;
  store::History& history;
  Membership* membership;        ///< null: this gateway shares nothing by a store
  const std::uint64_t& started;  ///< when this daemon was, seconds since 1970
};

/// The reply is made by a child process, of what is known now.
[[nodiscard]] Response made_aside(Context& context, const Asker& asker, Aside::Make make);
/// The reply is made in slices, each of what is known when it is made; after a reload the rest is
/// an error.
[[nodiscard]] Response made_in_slices(Context& context, std::size_t least_bytes,
                                      std::function<serve::Slice()> next);
/// What is known of deliveries, in one turn or aside.
[[nodiscard]] Response known(Context& context, const Asker& asker, const Asked& asked);
/// On disk first, then in the kernel. After an error nothing has changed.
[[nodiscard]] Result<void> set_withdrawn(Context& context, std::size_t channel, bool withdrawn);
/// What a new admission would be given, or an error that says that there is no endpoint on the
/// other side to do `to_do` with.
[[nodiscard]] Body outcome_of(const Context& context, const core::Proposal& proposal,
                              const Asked& asked, const char* to_do);
/// A proposal for whoever only wants to know: where gateways share networks, as if that were
/// reserved which it needs. Not to be accepted. Everything is settled.
[[nodiscard]] core::Proposal as_it_could_be(Context& context, const core::Admission& admission);
/// Why there cannot be so many pairs of ends; nothing when there can. Each of them is decided and
/// reported: of one channel there are as many as in a description, and of all channels as many as
/// there is memory for, also at the next start.
[[nodiscard]] std::optional<std::string> lacks_pairs(const Context& context, const Asked& asked);

}  // namespace mlcca
