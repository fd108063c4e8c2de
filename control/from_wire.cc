// SPDX-License-Identifier: BSD-2-Clause
// Protobuf to plain structs: field by field, in the order of control.proto. Texts are moved.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "control/wire.hpp"
#include "control/wire_enums.hpp"

namespace mlcca::control {
namespace {

std::string text(std::string* from) { return std::move(*from); }

/// read() of each element of a repeated field.
template <class Wires, class Read>
auto all(Wires* from, Read read) {
  std::vector<decltype(read(*from->begin()))> result;
  result.reserve(static_cast<std::size_t>(from->size()));
  for (auto& wire : *from) result.push_back(read(wire));
  return result;
}

template <class Texts>
std::vector<std::string> texts(Texts* from) {
  return all(from, [](std::string& one) { return std::move(one); });
}

Attribute attribute(v1::Attribute& from) {
  return {.name = text(from.mutable_name()),
          .value = from.value(),
          .unit = text(from.mutable_unit()),
          .dynamic = from.dynamic()};
}

ReasonCount reason_count(v1::ReasonCount& from) {
  return {.reason = text(from.mutable_reason()), .frames = from.frames()};
}

Traffic traffic(v1::Traffic& from) {
  return {.passed = from.passed(),
          .dropped = from.dropped(),
          .unknown = from.unknown(),
          .reasons = all(from.mutable_reasons(), reason_count),
          .would_drop = from.would_drop(),
          .would_drop_reasons = all(from.mutable_would_drop_reasons(), reason_count)};
}

Unknown unknown(v1::Unknown& from) {
  return {.can_id = from.can_id(),
          .length = from.length(),
          .fd = from.fd(),
          .egress = from.egress(),
          .frames = from.frames(),
          .subject = from.subject(),
          .xl = from.xl(),
          .address = text(from.mutable_address()),
          .mac = text(from.mutable_mac())};
}

Interface interface(v1::Interface& from) {
  return {.name = text(from.mutable_name()),
          .ifindex = from.ifindex(),
          .network = text(from.mutable_network()),
          .identity = text(from.mutable_identity()),
          .profile = text(from.mutable_profile()),
          .managed = from.managed(),
          .up = from.up(),
          .can_state = text(from.mutable_can_state()),
          .bitrate = from.bitrate(),
          .gated = from.gated(),
          .slots = from.slots(),
          .ingress = traffic(*from.mutable_ingress()),
          .egress = traffic(*from.mutable_egress()),
          .unknown = all(from.mutable_unknown(), unknown),
          .problem = text(from.mutable_problem()),
          .drops_early = from.drops_early(),
          .hook = text(from.mutable_hook()),
          .drift = text(from.mutable_drift()),
          .repaired = from.repaired(),
          .bypassed = from.bypassed()};
}

GateSlot gate_slot(v1::GateSlot& from) {
  return {.name = text(from.mutable_name()),
          .egress = from.egress(),
          .passes = from.passes(),
          .id = from.id(),
          .mask = from.mask(),
          .formats = text(from.mutable_formats()),
          .max_length = from.max_length(),
          .source = text(from.mutable_source()),
          .per_frame_ns = from.per_frame_ns(),
          .per_byte = from.per_byte(),
          .tolerance_ns = from.tolerance_ns(),
          .excess_passes = from.excess_passes(),
          .passed = from.passed(),
          .dropped = from.dropped(),
          .excess = from.excess(),
          .bytes = from.bytes(),
          .last_reason = text(from.mutable_last_reason()),
          .would_drop = from.would_drop()};
}

Gate gate(v1::Gate& from) {
  return {.interface = text(from.mutable_interface()),
          .network = text(from.mutable_network()),
          .profile = text(from.mutable_profile()),
          .attached = from.attached(),
          .problem = text(from.mutable_problem()),
          .slots = from.slots(),
          .room = from.room(),
          .masked = from.masked(),
          .masked_room = from.masked_room(),
          .control = all(from.mutable_control(), gate_slot),
          .channels = all(from.mutable_channels(), gate_slot)};
}

Network network(v1::Network& from) {
  return {.name = text(from.mutable_name()),
          .kind = text(from.mutable_kind()),
          .profile = text(from.mutable_profile()),
          .provision = all(from.mutable_provision(), attribute),
          .capacity_known = from.capacity_known(),
          .capacity = from.capacity(),
          .reserved = from.reserved(),
          .available = from.available(),
          .problem = text(from.mutable_problem()),
          .gateways = texts(from.mutable_gateways())};
}

Row row(v1::Row& from) {
  return {.where = text(from.mutable_where()),
          .attribute = text(from.mutable_attribute()),
          .unit = text(from.mutable_unit()),
          .required = from.required(),
          .provided_known = from.provided_known(),
          .provided = from.provided(),
          .dynamic = from.dynamic(),
          .outcome = outcome(from.outcome()),
          .margin = text(from.mutable_margin())};
}

MediumUse medium_use(v1::MediumUse& from) {
  return {.network = text(from.mutable_network()),
          .response_ns = from.response_ns(),
          .guaranteed_ns = from.guaranteed_ns(),
          .paper_rate = from.paper_rate(),
          .available = from.available(),
          .limiting_domain = text(from.mutable_limiting_domain()),
          .nodes = texts(from.mutable_nodes())};
}

Watch watch(const v1::Watch& from) {
  return {.period_ns = from.period_ns(),
          .silence_ns = from.silence_ns(),
          .missing_now = from.missing_now(),
          .events = from.events(),
          .missing = from.missing(),
          .since_last_ns = from.since_last_ns(),
          .last_gap_ns = from.last_gap_ns(),
          .shortest_gap_ns = from.shortest_gap_ns(),
          .longest_gap_ns = from.longest_gap_ns(),
          .jitter_ns = from.jitter_ns(),
          .rate_mhz = from.rate_mhz(),
          .gaps = {from.gaps().begin(), from.gaps().end()}};
}

Channel channel(v1::Channel& from) {
  return {.subject = from.subject(),
          .name = text(from.mutable_name()),
          .description = text(from.mutable_description()),
          .publisher = text(from.mutable_publisher()),
          .from = text(from.mutable_from()),
          .to = text(from.mutable_to()),
          .subscribers = texts(from.mutable_subscribers()),
          .granted = from.granted(),
          .reason = text(from.mutable_reason()),
          .route = texts(from.mutable_route()),
          .rows = all(from.mutable_rows(), row),
          .admission = from.admission(),
          .set = from.set(),
          .sets = std::max(from.sets(), 1U),
          .importance = from.importance(),
          .media = all(from.mutable_media(), medium_use),
          .passed = from.passed(),
          .dropped = from.dropped(),
          .excess = from.excess(),
          .reaction = text(from.mutable_reaction()),
          .watch = from.has_watch() ? std::optional(watch(from.watch())) : std::nullopt,
          .troubles = texts(from.mutable_troubles()),
          .subscribers_left_out = from.subscribers_left_out(),
          .withdrawn = from.withdrawn(),
          .would_drop = from.would_drop(),
          .rows_left_out = from.rows_left_out()};
}

RouteReport route_report(v1::RouteReport& from) {
  return {.from = text(from.mutable_from()),
          .to = text(from.mutable_to()),
          .places = texts(from.mutable_places()),
          .granted = from.granted(),
          .refused = from.refused(),
          .media = all(from.mutable_media(), medium_use),
          .problem = text(from.mutable_problem())};
}

MeshLink mesh_link(v1::MeshLink& from) {
  return {.network = text(from.mutable_network()),
          .from = text(from.mutable_from()),
          .to = text(from.mutable_to()),
          .rate = from.rate(),
          .believed_rate = from.believed_rate(),
          .kind = text(from.mutable_kind()),
          .loss_known = from.loss_known(),
          .loss = from.loss(),
          .busy_known = from.busy_known(),
          .busy = from.busy(),
          .age_ns = from.age_ns(),
          .stale = from.stale(),
          .source = text(from.mutable_source()),
          .lack = text(from.mutable_lack())};
}

CanRule can_rule(v1::CanRule& from) {
  return {.from = text(from.mutable_from()),
          .to = text(from.mutable_to()),
          .id = from.id(),
          .mask = from.mask(),
          .fd = from.fd(),
          .ours = from.ours(),
          .channel = text(from.mutable_channel()),
          .change = text(from.mutable_change()),
          .hops = from.hops(),
          .handled = from.handled(),
          .dropped = from.dropped(),
          .deleted = from.deleted()};
}

Reservation reservation(v1::Reservation& from) {
  return {.channel = text(from.mutable_channel()),
          .publisher = text(from.mutable_publisher()),
          .amount = from.amount(),
          .admission = from.admission(),
          .set = from.set(),
          .importance = from.importance(),
          .lease_ns = from.lease_ns()};
}

Resource resource(v1::Resource& from) {
  return {.name = text(from.mutable_name()),
          .kind = text(from.mutable_kind()),
          .unit = text(from.mutable_unit()),
          .capacity_known = from.capacity_known(),
          .capacity = from.capacity(),
          .reserved = from.reserved(),
          .background = from.background(),
          .reservations = all(from.mutable_reservations(), reservation)};
}

Outlook outlook(v1::Outlook& from) {
  return {.channel = text(from.mutable_channel()),
          .publisher = text(from.mutable_publisher()),
          .to = text(from.mutable_to()),
          .granted_now = from.granted_now(),
          .granted_then = from.granted_then(),
          .set_now = from.set_now(),
          .set_then = from.set_then(),
          .reason = text(from.mutable_reason())};
}

template <class Message>
std::optional<Actor> actor(Message& from) {
  if (!from.has_by()) return std::nullopt;
  return Actor{.uid = from.by().uid(),
               .user = text(from.mutable_by()->mutable_user()),
               .pid = from.by().pid()};
}

HistoryEntry history_entry(v1::HistoryEntry& from) {
  return {.unix_ns = from.unix_ns(),
          .kind = text(from.mutable_kind()),
          .subject = from.subject(),
          .channel = text(from.mutable_channel()),
          .from = text(from.mutable_from()),
          .to = text(from.mutable_to()),
          .network = text(from.mutable_network()),
          .message = text(from.mutable_message()),
          .by = actor(from)};
}

LinkChange link_change(v1::LinkChange& from) {
  return {.network = text(from.mutable_network()),
          .from = text(from.mutable_from()),
          .to = text(from.mutable_to()),
          .rate = from.rate(),
          .both_ways = !from.one_way()};
}

Identifier identifier(v1::Identifier& from) {
  return {.network = text(from.mutable_network()), .id = from.id(), .extended = from.extended()};
}

template <class Body>
Body channel_request(v1::ChannelRequest& from) {
  Body to;
  to.channel = text(from.mutable_channel());
  to.from = text(from.mutable_from());
  to.to = text(from.mutable_to());
  to.offered = all(from.mutable_offered(), attribute);
  to.required = all(from.mutable_required(), attribute);
  if (from.has_node()) to.node = from.node();
  if (from.has_priority()) to.priority = from.priority();
  to.user = text(from.mutable_user());
  to.subscriber = text(from.mutable_subscriber());
  to.publisher = text(from.mutable_publisher());
  to.from_node = text(from.mutable_from_node());
  to.to_node = text(from.mutable_to_node());
  to.address = text(from.mutable_address());
  to.unlisted = from.unlisted();
  to.identifiers = all(from.mutable_identifiers(), identifier);
  return to;
}

Admit admit(v1::ChannelRequest& from) {
  auto to = channel_request<Admit>(from);
  to.key = text(from.mutable_key());
  to.lease_ns = from.lease_ns();
  to.hold = from.hold();
  return to;
}

WhatIfRequest what_if_request(v1::WhatIfRequest& from) {
  return {.links = all(from.mutable_links(), link_change),
          .without = texts(from.mutable_without())};
}

HistoryRequest history_request(v1::HistoryRequest& from) {
  return {.channel = text(from.mutable_channel()),
          .kind = text(from.mutable_kind()),
          .since_unix_ns = from.since_unix_ns(),
          .until_unix_ns = from.until_unix_ns(),
          .limit = from.limit()};
}

Error error(v1::Error& from) {
  return {.kind = error_kind(from.kind()),
          .message = text(from.mutable_message()),
          .details = texts(from.mutable_details())};
}

Health health(v1::Health& from) {
  return {.state = health_state(from.state()),
          .reasons = texts(from.mutable_reasons()),
          .left_out = from.left_out()};
}

Status status(v1::Status& from) {
  return {.version = text(from.mutable_version()),
          .gateway = text(from.mutable_gateway()),
          .system = text(from.mutable_system()),
          .description_file = text(from.mutable_description_file()),
          .mode = text(from.mutable_mode()),
          .open = from.open(),
          .grace_ns = from.grace_ns(),
          .lapses = from.lapses(),
          .channels_granted = from.channels_granted(),
          .channels_refused = from.channels_refused(),
          .started_unix_s = from.started_unix_s(),
          .loaded_unix_s = from.loaded_unix_s(),
          .last_error = text(from.mutable_last_error()),
          .interfaces = all(from.mutable_interfaces(), interface),
          .problem = text(from.mutable_problem()),
          .health = health(*from.mutable_health())};
}

Event event(v1::Event& from) {
  return {.unix_ns = from.unix_ns(),
          .kind = text(from.mutable_kind()),
          .subject = from.subject(),
          .channel = text(from.mutable_channel()),
          .network = text(from.mutable_network()),
          .message = text(from.mutable_message()),
          .admissions = {from.admissions().begin(), from.admissions().end()},
          .silent_ns = from.silent_ns(),
          .missing = from.missing(),
          .by = actor(from)};
}

Routes routes(v1::Routes& from) {
  return {.routes = all(from.mutable_routes(), route_report),
          .links = all(from.mutable_links(), mesh_link),
          .problems = texts(from.mutable_problems()),
          .can_rules = all(from.mutable_can_rules(), can_rule)};
}

WhatIf what_if(v1::WhatIf& from) {
  return {.outlooks = all(from.mutable_outlooks(), outlook), .unchanged = from.unchanged()};
}

}  // namespace

Result<Request> from_wire(v1::Request& from) {
  const auto id = from.id();
  switch (from.body_case()) {
    case v1::Request::kStatus:
      return Request{id, StatusRequest{}};
    case v1::Request::kNetworks:
      return Request{id, NetworksRequest{}};
    case v1::Request::kChannels:
      return Request{id, ChannelsRequest{}};
    case v1::Request::kQuery:
      return Request{id, channel_request<Query>(*from.mutable_query())};
    case v1::Request::kAdmit:
      return Request{id, admit(*from.mutable_admit())};
    case v1::Request::kRelease:
      return Request{id, ReleaseRequest{.channel = text(from.mutable_release()->mutable_channel()),
                                        .admission = from.release().admission(),
                                        .key = text(from.mutable_release()->mutable_key())}};
    case v1::Request::kWithdraw:
      return Request{id, WithdrawRequest{text(from.mutable_withdraw()->mutable_channel())}};
    case v1::Request::kReinstate:
      return Request{id, ReinstateRequest{text(from.mutable_reinstate()->mutable_channel())}};
    case v1::Request::kExplain:
      return Request{id, ExplainRequest{text(from.mutable_explain()->mutable_channel())}};
    case v1::Request::kMonitor:
      return Request{id, MonitorRequest{}};
    case v1::Request::kMode:
      return Request{id, ModeRequest{text(from.mutable_mode()->mutable_mode())}};
    case v1::Request::kReload:
      return Request{id, ReloadRequest{}};
    case v1::Request::kRenew:
      return Request{id, RenewRequest{.admission = from.renew().admission(),
                                      .key = text(from.mutable_renew()->mutable_key())}};
    case v1::Request::kRoutes:
      return Request{id, RoutesRequest{}};
    case v1::Request::kReservations:
      return Request{id, ReservationsRequest{text(from.mutable_reservations()->mutable_place())}};
    case v1::Request::kGate:
      return Request{id, GateRequest{text(from.mutable_gate()->mutable_place())}};
    case v1::Request::kWhatIf:
      return Request{id, what_if_request(*from.mutable_what_if())};
    case v1::Request::kHistory:
      return Request{id, history_request(*from.mutable_history())};
    case v1::Request::BODY_NOT_SET:
      break;
  }
  return fail("unknown request: this mlccad does not know it; is the client newer?");
}

Result<Reply> from_wire(v1::Reply& from) {
  const auto id = from.id();
  switch (from.body_case()) {
    case v1::Reply::kError:
      return Reply{id, error(*from.mutable_error())};
    case v1::Reply::kStatus:
      return Reply{id, status(*from.mutable_status())};
    case v1::Reply::kNetworks:
      return Reply{id, Networks{all(from.mutable_networks()->mutable_networks(), network)}};
    case v1::Reply::kChannels:
      return Reply{id, Channels{all(from.mutable_channels()->mutable_channels(), channel),
                                from.channels().left_out()}};
    case v1::Reply::kDone:
      return Reply{id, Done{text(from.mutable_done()->mutable_message())}};
    case v1::Reply::kEvent:
      return Reply{id, event(*from.mutable_event())};
    case v1::Reply::kRoutes:
      return Reply{id, routes(*from.mutable_routes())};
    case v1::Reply::kReservations:
      return Reply{id,
                   Reservations{all(from.mutable_reservations()->mutable_resources(), resource)}};
    case v1::Reply::kGates:
      return Reply{id, Gates{all(from.mutable_gates()->mutable_gates(), gate)}};
    case v1::Reply::kWhatIf:
      return Reply{id, what_if(*from.mutable_what_if())};
    case v1::Reply::kHistory:
      return Reply{id, History{all(from.mutable_history()->mutable_entries(), history_entry)}};
    case v1::Reply::BODY_NOT_SET:
      break;
  }
  return fail("unknown reply: this program does not know it; is mlccad newer?");
}

}  // namespace mlcca::control
