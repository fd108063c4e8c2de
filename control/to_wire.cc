// SPDX-License-Identifier: BSD-2-Clause
// Plain structs to protobuf: field by field, in the order of control.proto.
#include <variant>

#include "control/utf8.hpp"
#include "control/wire.hpp"
#include "control/wire_enums.hpp"

namespace mlcca::control {
namespace {

void put(const Attribute& from, v1::Attribute& to) {
  to.set_name(to_utf8(from.name));
  to.set_value(from.value);
  to.set_unit(to_utf8(from.unit));
  to.set_dynamic(from.dynamic);
}

void put(const ReasonCount& from, v1::ReasonCount& to) {
  to.set_reason(to_utf8(from.reason));
  to.set_frames(from.frames);
}

void put(const Traffic& from, v1::Traffic& to) {
  to.set_passed(from.passed);
  to.set_dropped(from.dropped);
  to.set_unknown(from.unknown);
  for (const auto& count : from.reasons) put(count, *to.add_reasons());
  to.set_would_drop(from.would_drop);
  for (const auto& count : from.would_drop_reasons) put(count, *to.add_would_drop_reasons());
}

void put(const Unknown& from, v1::Unknown& to) {
  to.set_can_id(from.can_id);
  to.set_length(from.length);
  to.set_fd(from.fd);
  to.set_egress(from.egress);
  to.set_frames(from.frames);
  to.set_subject(from.subject);
  to.set_xl(from.xl);
  to.set_address(to_utf8(from.address));
  to.set_mac(to_utf8(from.mac));
}

void put(const Interface& from, v1::Interface& to) {
  to.set_name(to_utf8(from.name));
  to.set_ifindex(from.ifindex);
  to.set_network(to_utf8(from.network));
  to.set_identity(to_utf8(from.identity));
  to.set_profile(to_utf8(from.profile));
  to.set_managed(from.managed);
  to.set_up(from.up);
  to.set_can_state(to_utf8(from.can_state));
  to.set_bitrate(from.bitrate);
  to.set_gated(from.gated);
  to.set_slots(from.slots);
  put(from.ingress, *to.mutable_ingress());
  put(from.egress, *to.mutable_egress());
  for (const auto& unknown : from.unknown) put(unknown, *to.add_unknown());
  to.set_problem(to_utf8(from.problem));
  to.set_drops_early(from.drops_early);
  to.set_hook(to_utf8(from.hook));
  to.set_drift(to_utf8(from.drift));
  to.set_repaired(from.repaired);
  to.set_bypassed(from.bypassed);
}

void put(const GateSlot& from, v1::GateSlot& to) {
  to.set_name(to_utf8(from.name));
  to.set_egress(from.egress);
  to.set_passes(from.passes);
  to.set_id(from.id);
  to.set_mask(from.mask);
  to.set_formats(to_utf8(from.formats));
  to.set_max_length(from.max_length);
  to.set_source(to_utf8(from.source));
  to.set_per_frame_ns(from.per_frame_ns);
  to.set_per_byte(from.per_byte);
  to.set_tolerance_ns(from.tolerance_ns);
  to.set_excess_passes(from.excess_passes);
  to.set_passed(from.passed);
  to.set_dropped(from.dropped);
  to.set_excess(from.excess);
  to.set_bytes(from.bytes);
  to.set_last_reason(to_utf8(from.last_reason));
  to.set_would_drop(from.would_drop);
}

void put(const Gate& from, v1::Gate& to) {
  to.set_interface(to_utf8(from.interface));
  to.set_network(to_utf8(from.network));
  to.set_profile(to_utf8(from.profile));
  to.set_attached(from.attached);
  to.set_problem(to_utf8(from.problem));
  to.set_slots(from.slots);
  to.set_room(from.room);
  to.set_masked(from.masked);
  to.set_masked_room(from.masked_room);
  for (const auto& slot : from.control) put(slot, *to.add_control());
  for (const auto& slot : from.channels) put(slot, *to.add_channels());
}

void put(const Network& from, v1::Network& to) {
  to.set_name(to_utf8(from.name));
  to.set_kind(to_utf8(from.kind));
  to.set_profile(to_utf8(from.profile));
  for (const auto& attribute : from.provision) put(attribute, *to.add_provision());
  to.set_capacity_known(from.capacity_known);
  to.set_capacity(from.capacity);
  to.set_reserved(from.reserved);
  to.set_available(from.available);
  to.set_problem(to_utf8(from.problem));
  for (const auto& gateway : from.gateways) to.add_gateways(to_utf8(gateway));
}

void put(const Row& from, v1::Row& to) {
  to.set_where(to_utf8(from.where));
  to.set_attribute(to_utf8(from.attribute));
  to.set_unit(to_utf8(from.unit));
  to.set_required(from.required);
  to.set_provided_known(from.provided_known);
  to.set_provided(from.provided);
  to.set_dynamic(from.dynamic);
  to.set_outcome(to_wire(from.outcome));
  to.set_margin(to_utf8(from.margin));
}

void put(const MediumUse& from, v1::MediumUse& to) {
  to.set_network(to_utf8(from.network));
  to.set_response_ns(from.response_ns);
  to.set_guaranteed_ns(from.guaranteed_ns);
  to.set_paper_rate(from.paper_rate);
  to.set_available(from.available);
  to.set_limiting_domain(to_utf8(from.limiting_domain));
  for (const auto& node : from.nodes) to.add_nodes(to_utf8(node));
}

void put(const Watch& from, v1::Watch& to) {
  to.set_period_ns(from.period_ns);
  to.set_silence_ns(from.silence_ns);
  to.set_missing_now(from.missing_now);
  to.set_events(from.events);
  to.set_missing(from.missing);
  to.set_since_last_ns(from.since_last_ns);
  to.set_last_gap_ns(from.last_gap_ns);
  to.set_shortest_gap_ns(from.shortest_gap_ns);
  to.set_longest_gap_ns(from.longest_gap_ns);
  to.set_jitter_ns(from.jitter_ns);
  to.set_rate_mhz(from.rate_mhz);
  for (const auto count : from.gaps) to.add_gaps(count);
}

void put(const Channel& from, v1::Channel& to) {
  to.set_subject(from.subject);
  to.set_name(to_utf8(from.name));
  to.set_description(to_utf8(from.description));
  to.set_publisher(to_utf8(from.publisher));
  to.set_from(to_utf8(from.from));
  to.set_to(to_utf8(from.to));
  for (const auto& subscriber : from.subscribers) to.add_subscribers(to_utf8(subscriber));
  to.set_granted(from.granted);
  to.set_reason(to_utf8(from.reason));
  for (const auto& hop : from.route) to.add_route(to_utf8(hop));
  for (const auto& row : from.rows) put(row, *to.add_rows());
  to.set_admission(from.admission);
  to.set_passed(from.passed);
  to.set_dropped(from.dropped);
  to.set_excess(from.excess);
  to.set_would_drop(from.would_drop);
  to.set_reaction(to_utf8(from.reaction));
  to.set_set(from.set);
  to.set_sets(from.sets);
  to.set_importance(from.importance);
  for (const auto& use : from.media) put(use, *to.add_media());
  if (from.watch) put(*from.watch, *to.mutable_watch());
  for (const auto& trouble : from.troubles) to.add_troubles(to_utf8(trouble));
  to.set_withdrawn(from.withdrawn);
  to.set_subscribers_left_out(from.subscribers_left_out);
  to.set_rows_left_out(from.rows_left_out);
}

void put(const Health& from, v1::Health& to) {
  to.set_state(to_wire(from.state));
  for (const auto& reason : from.reasons) to.add_reasons(to_utf8(reason));
  to.set_left_out(from.left_out);
}

void put(const RouteReport& from, v1::RouteReport& to) {
  to.set_from(to_utf8(from.from));
  to.set_to(to_utf8(from.to));
  for (const auto& place : from.places) to.add_places(to_utf8(place));
  to.set_granted(from.granted);
  to.set_refused(from.refused);
  for (const auto& use : from.media) put(use, *to.add_media());
  to.set_problem(to_utf8(from.problem));
}

void put(const MeshLink& from, v1::MeshLink& to) {
  to.set_network(to_utf8(from.network));
  to.set_from(to_utf8(from.from));
  to.set_to(to_utf8(from.to));
  to.set_rate(from.rate);
  to.set_believed_rate(from.believed_rate);
  to.set_kind(to_utf8(from.kind));
  to.set_loss_known(from.loss_known);
  to.set_loss(from.loss);
  to.set_busy_known(from.busy_known);
  to.set_busy(from.busy);
  to.set_age_ns(from.age_ns);
  to.set_stale(from.stale);
  to.set_source(to_utf8(from.source));
  to.set_lack(to_utf8(from.lack));
}

void put(const CanRule& from, v1::CanRule& to) {
  to.set_from(to_utf8(from.from));
  to.set_to(to_utf8(from.to));
  to.set_id(from.id);
  to.set_mask(from.mask);
  to.set_fd(from.fd);
  to.set_ours(from.ours);
  to.set_channel(to_utf8(from.channel));
  to.set_change(to_utf8(from.change));
  to.set_hops(from.hops);
  to.set_handled(from.handled);
  to.set_dropped(from.dropped);
  to.set_deleted(from.deleted);
}

void put(const Reservation& from, v1::Reservation& to) {
  to.set_channel(to_utf8(from.channel));
  to.set_publisher(to_utf8(from.publisher));
  to.set_amount(from.amount);
  to.set_admission(from.admission);
  to.set_set(from.set);
  to.set_importance(from.importance);
  to.set_lease_ns(from.lease_ns);
}

void put(const Resource& from, v1::Resource& to) {
  to.set_name(to_utf8(from.name));
  to.set_kind(to_utf8(from.kind));
  to.set_unit(to_utf8(from.unit));
  to.set_capacity_known(from.capacity_known);
  to.set_capacity(from.capacity);
  to.set_reserved(from.reserved);
  to.set_background(from.background);
  for (const auto& reservation : from.reservations) put(reservation, *to.add_reservations());
}

void put(const Outlook& from, v1::Outlook& to) {
  to.set_channel(to_utf8(from.channel));
  to.set_publisher(to_utf8(from.publisher));
  to.set_to(to_utf8(from.to));
  to.set_granted_now(from.granted_now);
  to.set_granted_then(from.granted_then);
  to.set_set_now(from.set_now);
  to.set_set_then(from.set_then);
  to.set_reason(to_utf8(from.reason));
}

void put(const Actor& from, v1::Actor& to) {
  to.set_uid(from.uid);
  to.set_user(to_utf8(from.user));
  to.set_pid(from.pid);
}

void put(const HistoryEntry& from, v1::HistoryEntry& to) {
  to.set_unix_ns(from.unix_ns);
  to.set_kind(to_utf8(from.kind));
  to.set_subject(from.subject);
  to.set_channel(to_utf8(from.channel));
  to.set_from(to_utf8(from.from));
  to.set_to(to_utf8(from.to));
  to.set_network(to_utf8(from.network));
  to.set_message(to_utf8(from.message));
  if (from.by) put(*from.by, *to.mutable_by());
}

void put(const LinkChange& from, v1::LinkChange& to) {
  to.set_network(to_utf8(from.network));
  to.set_from(to_utf8(from.from));
  to.set_to(to_utf8(from.to));
  to.set_rate(from.rate);
  to.set_one_way(!from.both_ways);
}

void put(const ChannelRequest& from, v1::ChannelRequest& to) {
  to.set_channel(to_utf8(from.channel));
  to.set_from(to_utf8(from.from));
  to.set_to(to_utf8(from.to));
  for (const auto& attribute : from.offered) put(attribute, *to.add_offered());
  for (const auto& attribute : from.required) put(attribute, *to.add_required());
  if (from.node) to.set_node(*from.node);
  if (from.priority) to.set_priority(*from.priority);
  to.set_user(to_utf8(from.user));
  to.set_subscriber(to_utf8(from.subscriber));
  to.set_publisher(to_utf8(from.publisher));
  to.set_from_node(to_utf8(from.from_node));
  to.set_to_node(to_utf8(from.to_node));
  to.set_address(to_utf8(from.address));
  to.set_unlisted(from.unlisted);
  for (const auto& identifier : from.identifiers) {
    auto& wire = *to.add_identifiers();
    wire.set_network(to_utf8(identifier.network));
    wire.set_id(identifier.id);
    wire.set_extended(identifier.extended);
  }
}

/// One function for each alternative of Request::body.
struct RequestBody {
  v1::Request& to;

  void operator()(const StatusRequest&) const { to.mutable_status(); }
  void operator()(const NetworksRequest&) const { to.mutable_networks(); }
  void operator()(const ChannelsRequest&) const { to.mutable_channels(); }
  void operator()(const Query& from) const { put(from, *to.mutable_query()); }
  void operator()(const Admit& from) const {
    auto& admit = *to.mutable_admit();
    put(from, admit);
    admit.set_key(to_utf8(from.key));
    admit.set_lease_ns(from.lease_ns);
    admit.set_hold(from.hold);
  }
  void operator()(const ReleaseRequest& from) const {
    to.mutable_release()->set_channel(to_utf8(from.channel));
    to.mutable_release()->set_admission(from.admission);
    to.mutable_release()->set_key(to_utf8(from.key));
  }
  void operator()(const WithdrawRequest& from) const {
    to.mutable_withdraw()->set_channel(to_utf8(from.channel));
  }
  void operator()(const ReinstateRequest& from) const {
    to.mutable_reinstate()->set_channel(to_utf8(from.channel));
  }
  void operator()(const ExplainRequest& from) const {
    to.mutable_explain()->set_channel(to_utf8(from.channel));
  }
  void operator()(const MonitorRequest&) const { to.mutable_monitor(); }
  void operator()(const ModeRequest& from) const {
    to.mutable_mode()->set_mode(to_utf8(from.mode));
  }
  void operator()(const ReloadRequest&) const { to.mutable_reload(); }
  void operator()(const RenewRequest& from) const {
    to.mutable_renew()->set_admission(from.admission);
    to.mutable_renew()->set_key(to_utf8(from.key));
  }
  void operator()(const RoutesRequest&) const { to.mutable_routes(); }
  void operator()(const GateRequest& from) const {
    to.mutable_gate()->set_place(to_utf8(from.place));
  }
  void operator()(const ReservationsRequest& from) const {
    to.mutable_reservations()->set_place(to_utf8(from.place));
  }
  void operator()(const WhatIfRequest& from) const {
    auto& what_if = *to.mutable_what_if();
    for (const auto& link : from.links) put(link, *what_if.add_links());
    for (const auto& name : from.without) what_if.add_without(to_utf8(name));
  }
  void operator()(const HistoryRequest& from) const {
    auto& history = *to.mutable_history();
    history.set_channel(to_utf8(from.channel));
    history.set_kind(to_utf8(from.kind));
    history.set_since_unix_ns(from.since_unix_ns);
    history.set_until_unix_ns(from.until_unix_ns);
    history.set_limit(from.limit);
  }
};

/// One function for each alternative of Reply::body.
struct ReplyBody {
  v1::Reply& to;

  void operator()(const Error& from) const {
    auto& error = *to.mutable_error();
    error.set_kind(to_wire(from.kind));
    error.set_message(to_utf8(from.message));
    for (const auto& detail : from.details) error.add_details(to_utf8(detail));
  }
  void operator()(const Status& from) const {
    auto& status = *to.mutable_status();
    status.set_version(to_utf8(from.version));
    status.set_gateway(to_utf8(from.gateway));
    status.set_system(to_utf8(from.system));
    status.set_description_file(to_utf8(from.description_file));
    status.set_mode(to_utf8(from.mode));
    status.set_open(from.open);
    status.set_grace_ns(from.grace_ns);
    status.set_lapses(from.lapses);
    status.set_channels_granted(from.channels_granted);
    status.set_channels_refused(from.channels_refused);
    status.set_started_unix_s(from.started_unix_s);
    status.set_loaded_unix_s(from.loaded_unix_s);
    status.set_last_error(to_utf8(from.last_error));
    for (const auto& interface : from.interfaces) put(interface, *status.add_interfaces());
    status.set_problem(to_utf8(from.problem));
    put(from.health, *status.mutable_health());
  }
  void operator()(const Networks& from) const {
    auto& networks = *to.mutable_networks();
    for (const auto& network : from.networks) put(network, *networks.add_networks());
  }
  void operator()(const Channels& from) const {
    auto& channels = *to.mutable_channels();
    for (const auto& channel : from.channels) put(channel, *channels.add_channels());
    channels.set_left_out(from.left_out);
  }
  void operator()(const Done& from) const { to.mutable_done()->set_message(to_utf8(from.message)); }
  void operator()(const Event& from) const {
    auto& event = *to.mutable_event();
    event.set_unix_ns(from.unix_ns);
    event.set_kind(to_utf8(from.kind));
    event.set_subject(from.subject);
    event.set_channel(to_utf8(from.channel));
    event.set_network(to_utf8(from.network));
    event.set_message(to_utf8(from.message));
    for (const auto admission : from.admissions) event.add_admissions(admission);
    event.set_silent_ns(from.silent_ns);
    event.set_missing(from.missing);
    if (from.by) put(*from.by, *event.mutable_by());
  }
  void operator()(const Routes& from) const {
    auto& routes = *to.mutable_routes();
    for (const auto& route : from.routes) put(route, *routes.add_routes());
    for (const auto& link : from.links) put(link, *routes.add_links());
    for (const auto& problem : from.problems) routes.add_problems(to_utf8(problem));
    for (const auto& rule : from.can_rules) put(rule, *routes.add_can_rules());
  }
  void operator()(const Gates& from) const {
    auto& gates = *to.mutable_gates();
    for (const auto& gate : from.gates) put(gate, *gates.add_gates());
  }
  void operator()(const Reservations& from) const {
    auto& reservations = *to.mutable_reservations();
    for (const auto& resource : from.resources) put(resource, *reservations.add_resources());
  }
  void operator()(const WhatIf& from) const {
    auto& what_if = *to.mutable_what_if();
    for (const auto& outlook : from.outlooks) put(outlook, *what_if.add_outlooks());
    what_if.set_unchanged(from.unchanged);
  }
  void operator()(const History& from) const {
    auto& history = *to.mutable_history();
    for (const auto& entry : from.entries) put(entry, *history.add_entries());
  }
};

}  // namespace

void to_wire(const Request& from, v1::Request& to) {
  to.set_id(from.id);
  to.set_slices(from.slices);
  std::visit(RequestBody{to}, from.body);
}

void to_wire(const Reply& from, v1::Reply& to) {
  to.set_id(from.id);
  to.set_more(from.more);
  std::visit(ReplyBody{to}, from.body);
}

}  // namespace mlcca::control
