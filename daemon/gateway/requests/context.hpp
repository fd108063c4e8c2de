// SPDX-License-Identifier: BSD-2-Clause
// The parts of a gateway that handlers of requests use, and functions that several handlers share.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "daemon/gateway/aside.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"
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

/// All references outlive every request and every slice of a reply.
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
  Membership* membership;        ///< null: this gateway is in no cluster
  const std::uint64_t& started;  ///< when this daemon was started, seconds since 1970
};

/// A reply that a child process makes of what is known now.
[[nodiscard]] Response made_aside(Context& context, const Asker& asker, Aside::Make make);
/// A reply in slices, each made of what is known at its time. After a reload the rest is an error.
[[nodiscard]] Response made_in_slices(Context& context, std::size_t least_bytes,
                                      std::function<serve::Slice()> next);
/// What is known of deliveries, made in one turn or by a child process.
[[nodiscard]] Response known(Context& context, const Asker& asker, const ParsedRequest& asked);
/// Withdraws or reinstates a channel: on disk first, then in the kernel. After an error nothing has
/// changed.
[[nodiscard]] Result<void> set_withdrawn(Context& context, std::size_t channel, bool withdrawn);
/// What a new admission would be given; or an error that says that there is no endpoint on the
/// other side to do `to_do` with.
[[nodiscard]] Body outcome_of(const Context& context, const core::Proposal& proposal,
                              const ParsedRequest& asked, const char* to_do);
/// A proposal that only answers a question and must not be accepted. Where gateways share networks,
/// it is decided as if what it needs were reserved. Everything must be settled.
[[nodiscard]] core::Proposal as_it_could_be(Context& context, const core::Admission& admission);
/// Why there cannot be the additional pairs of ends that this request makes; nullopt if there can.
/// Each pair is decided and reported: one channel may have as many as in a description, and all
/// channels as many as memory allows, also at the next start.
[[nodiscard]] std::optional<std::string> lacks_pairs(const Context& context,
                                                     const ParsedRequest& asked);

}  // namespace mlcca
