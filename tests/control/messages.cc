// SPDX-License-Identifier: BSD-2-Clause
#include "tests/control/messages.hpp"

namespace mlcca::test {

using namespace control;

Channel refused_channel() {
  return {.subject = 0xa4efeccc3210b497,
          .name = "emergency-switch",
          .description = "stops the motors",
          .publisher = "switch",
          .from = "second-can",
          .to = "robot-can",
          .subscribers = {"motor-left", "motor-right"},
          .granted = false,
          .reason = "Omission 2 required, bridge provides 5 (3 too many)",
          .route = {"second-can", "bridge", "robot-can"},
          .rows = {{.where = "second-can",
                    .attribute = "Period",
                    .unit = "ns",
                    .required = 50'000'000,
                    .provided_known = true,
                    .provided = 12'500'000,
                    .dynamic = false,
                    .outcome = Outcome::fit,
                    .margin = "37.5 ms to spare"},
                   {.where = "bridge",
                    .attribute = "Omission",
                    .unit = "events",
                    .required = 2,
                    .provided_known = true,
                    .provided = 5,
                    .dynamic = false,
                    .outcome = Outcome::unfit,
                    .margin = "3 too many"},
                   {.where = "robot-can",
                    .attribute = "PacketLoss",
                    .unit = "1e-9",
                    .required = 5'000'000,
                    .provided_known = true,
                    .provided = 1'000'000,
                    .dynamic = true,
                    .outcome = Outcome::run_time,
                    .margin = "0.4 % to spare"},
                   {.where = "end to end",
                    .attribute = "Bandwidth",
                    .unit = "bytes/s",
                    .required = 400'000,
                    .provided_known = false,
                    .provided = 0,
                    .dynamic = false,
                    .outcome = Outcome::unfit,
                    .margin = "not provided"}},
          .admission = 0,
          .passed = 12,
          .dropped = 345,
          .reaction = {},
          .set = 0,
          .sets = 1,
          .importance = 3,
          .media = {},
          .excess = 6,
          .watch = {},
          .margin = Margin{.where = "bridge",
                           .attribute = "Omission",
                           .unit = "events",
                           .outcome = Outcome::unfit,
                           .amount_known = true,
                           .amount = 3,
                           .words = "3 too many"}};
}

Watch full_watch() {
  return {.period_ns = 50'000'000,
          .timeout_ns = 162'075'000,
          .missing_now = true,
          .events = 1001,
          .missing = 4,
          .since_last_ns = 200'000'000,
          .last_gap_ns = 49'000'000,
          .shortest_gap_ns = 44'000'000,
          .longest_gap_ns = 101'000'000,
          .jitter_ns = 6'000'000,
          .rate_millihertz = 19'975,
          .gaps = {0, 0, 0, 0, 0, 0, 0, 499, 500, 0, 0, 0, 0, 0, 0, 1},
          .silent_ns = 200'000'000};
}

Channel granted_channel() {
  auto channel = refused_channel();
  channel.from = "robot-can";
  channel.granted = true;
  channel.margin.reset();
  channel.reason = "Period 50 ms required, the route provides 12.5 ms (37.5 ms to spare)";
  channel.route = {"robot-can"};
  channel.rows.resize(1);
  channel.rows[0].where = "robot-can";
  channel.admission = 7;
  channel.dropped = 0;
  channel.would_drop = 12;
  channel.would_exceed = 5;
  channel.watch = full_watch();
  channel.problems = {"nothing has come for 200 ms: 4 events are missing"};
  channel.reaction = "174 ms = (Omission 2 + 1) x Period 50 ms + Latency 12 ms + Jitter 12 ms";
  return channel;
}

namespace {

MediumUse bus_use() {
  return {.network = "robot-can",
          .response_ns = 310'000,
          .guaranteed_ns = 5'000'000,
          .path_rate = 0,
          .available = 0,
          .limited_by = "",
          .path = {}};
}

/// 24 and 11 Mbit/s, one link after the other: 1 / (1/24 + 1/11) = 264/35 Mbit/s = 942857.1
/// bytes/s.
MediumUse mesh_use() {
  return {.network = "awds",
          .response_ns = 0,
          .guaranteed_ns = 0,
          .path_rate = 942'857,
          .available = 600'000,
          .limited_by = "all links",
          .path = {"laptop", "relay", "control"}};
}

}  // namespace

Channel switched_channel() {
  auto channel = granted_channel();
  channel.subject = 0x10;
  channel.name = "video";
  channel.from = "awds";
  channel.route = {"awds", "bridge", "robot-can"};
  channel.admission = 0;
  channel.reaction.clear();
  channel.watch.reset();
  channel.problems.clear();
  channel.set = 1;
  channel.sets = 2;
  channel.importance = 9;
  channel.media = {mesh_use(), bus_use()};
  return channel;
}

Status full_status() {
  Interface can0{
      .name = "can0",
      .ifindex = 3,
      .network = "robot-can",
      .identity = "name can0",
      .profile = "famouso",
      .managed = true,
      .up = true,
      .can_state = "ERROR-ACTIVE",
      .bitrate = 500'000,
      .attached = true,
      .slots = 4,
      .ingress = {.passed = 1001,
                  .dropped = 22,
                  .unknown = 21,
                  .reasons = {{"unknown", 21}, {"length", 1}}},
      .egress = {.passed = 2002,
                 .dropped = 33,
                 .unknown = 30,
                 .reasons = {{"source", 3}},
                 .would_drop = 34,
                 .would_drop_reasons = {{"more than admitted", 34}}},
      .unknown = {{.can_id = 0x98ffa533, .length = 8, .fd = false, .egress = false, .frames = 19},
                  {.can_id = 0x123, .length = 64, .fd = true, .egress = true, .frames = 2},
                  {.can_id = 0x17, .length = 2048, .egress = false, .frames = 1, .xl = true},
                  {.length = 8183,
                   .frames = 3,
                   .subject = 0xa4efeccc3210b497,
                   .address = "10.0.0.7",
                   .mac = "02:00:5e:10:00:01"}},
      .problem = "queue is full",
      .drops_early = true,
      .hook = "tcx",
      .drift = "before the gate of can0 runs another",
      .repaired = 3,
      .bypassed = 70000};
  Interface can1;
  can1.name = "can1";
  can1.network = "second-can";
  can1.problem = "no such interface";
  return {.version = "0.1.0",
          .gateway = "bridge",
          .system = "robot",
          .description_file = "/etc/mlcca/system.xml",
          .mode = "enforce",
          .open = true,
          .grace_ns = 10'000'000'000,
          .lapses = 2,
          .channels_granted = 3,
          .channels_refused = 1,
          .started_unix_s = 1'700'000'000,
          .loaded_unix_s = 1'700'000'100,
          .reload_error = "system.xml:7: <Period>: not a number",
          .interfaces = {can0, can1},
          .problem = "can1 is missing",
          .health = {.state = HealthState::degraded,
                     .reasons = {"can1 is missing", "1 delivery is refused"},
                     .left_out = 5}};
}

Networks full_networks() {
  return {{{.name = "robot-can",
            .kind = "can",
            .profile = "famouso",
            .provision = {{.name = "Latency", .value = 5'000'000, .unit = "ns", .dynamic = false},
                          {.name = "Omission", .value = 5, .unit = "events", .dynamic = true}},
            .capacity_known = true,
            .capacity = 40'000,
            .reserved = 160,
            .available = true,
            .problem = "",
            .gateways = {"bridge", "second-bridge"},
            .described_bitrate = 500'000,
            .described_data_bitrate = 2'000'000},
           {.name = "mesh",
            .kind = "mesh",
            .profile = "none",
            .provision = {},
            .capacity_known = false,
            .capacity = 0,
            .reserved = 0,
            .available = false,
            .problem = "wlan0 is down",
            .gateways = {}}}};
}

Event full_event() {
  return {.unix_ns = 1'700'000'000'123'456'789,
          .kind = "refused",
          .subject = 0xa4efeccc3210b497,
          .channel = "emergency-switch",
          .network = "robot-can",
          .message = "Omission 2 required, bridge provides 5",
          .admissions = {7, ~std::uint64_t{0}},
          .silent_ns = 174'000'000,
          .missing = 3,
          .client = Actor{.uid = 1000, .user = "alice", .pid = 4242},
          .frames = 12,
          .late = 5,
          .longest_ns = 7'000'000};
}

Routes full_routes() {
  return {.routes = {{.from = "awds",
                      .to = "robot-can",
                      .route = {"awds", "bridge", "robot-can"},
                      .granted = 2,
                      .refused = 1,
                      .media = {mesh_use(), bus_use()},
                      .problem = ""},
                     {.from = "second-can",
                      .to = "awds",
                      .route = {},
                      .granted = 0,
                      .refused = 3,
                      .media = {},
                      .problem = "no gateway leads there"}},
          .links = {{.network = "awds",
                     .from = "laptop",
                     .to = "relay",
                     .rate = 24'000'000,
                     .believed_rate = 22'500'000,
                     .kind = "phy",
                     .loss_known = true,
                     .loss = 12'500'000,
                     .busy_known = true,
                     .busy = 43'000,
                     .age_ns = 1'250'000'000,
                     .stale = false,
                     .source = "nl80211 mesh0",
                     .state = ""},
                    {.network = "awds",
                     .from = "relay",
                     .to = "02:00:00:00:00:03",
                     .rate = 0,
                     .believed_rate = 0,
                     .kind = "derived",
                     .loss_known = false,
                     .loss = 0,
                     .busy_known = false,
                     .busy = 0,
                     .age_ns = 60'000'000'000,
                     .stale = true,
                     .source = "awds eth1",
                     .state = "stale"}},
          .problems = {"awds: babel: connection refused", "awds: olsr: no such node"},
          .can_rules = {{.from = "can1",
                         .to = "can0",
                         .id = 0x9f480064,
                         .mask = 0xdfffffff,
                         .fd = true,
                         .ours = true,
                         .channel = "emergency-switch",
                         .change = "id to 1f480065",
                         .hops = 0,
                         .handled = 7'000'000'000,
                         .dropped = 1,
                         .deleted = 2},
                        {.from = "can0",
                         .to = "can2",
                         .id = 0x100,
                         .mask = 0x7ff,
                         .fd = false,
                         .ours = false,
                         .channel = "",
                         .change = "the frame",
                         .hops = 1,
                         .handled = 0,
                         .dropped = 0,
                         .deleted = 0}}};
}

Gates full_gates() {
  const GateSlot claim{.name = "address-claim",
                       .egress = true,
                       .passes = true,
                       .id = 0x80eeff00,
                       .mask = 0xc3ffff00,
                       .formats = "classic",
                       .max_length = 8,
                       .source = "user 0",
                       .per_frame_ns = 20'000'000,
                       .per_byte = 3,
                       .tolerance_ns = 5'120'000'000,
                       .excess_passes = true,
                       .passed = 7,
                       .dropped = 2,
                       .excess = 1,
                       .bytes = 56,
                       .last_reason = "more than admitted",
                       .would_drop = 4};
  auto channel = claim;
  channel.name = "engine-speed";
  channel.egress = false;
  channel.source = "";
  return {{{.interface = "can0",
            .network = "powertrain",
            .profile = "j1939",
            .attached = true,
            .problem = "can0 is down",
            .slots = 21,
            .slots_limit = 4094,
            .masked_slots = 3,
            .masked_slots_limit = 32,
            .control = {claim},
            .channels = {channel, claim}},
           {}}};
}

Reservations full_reservations() {
  const Reservation switch_on_bus{.channel = "emergency-switch",
                                  .publisher = "switch",
                                  .amount = 15'000,
                                  .admission = 0,
                                  .set = 0,
                                  .importance = 0,
                                  .lease_ns = 0};
  const Reservation video_on_mesh{.channel = "video",
                                  .publisher = "camera",
                                  .amount = 424'242'424'242,
                                  .admission = 8,
                                  .set = 1,
                                  .importance = 9,
                                  .lease_ns = 7'500'000'000};
  auto video = video_on_mesh;
  video.amount = 400'000;
  auto heartbeat = switch_on_bus;
  heartbeat.amount = 1'000'000;
  return {{{.name = "robot-can: bus time",
            .kind = "bus",
            .unit = "ppm",
            .capacity_known = true,
            .capacity = 600'000,
            .reserved = 15'000,
            .background = 100'000,
            .reservations = {switch_on_bus}},
           {.name = "awds: all links",
            .kind = "domain",
            .unit = "ps/s",
            .capacity_known = true,
            .capacity = 800'000'000'000,
            .reserved = 424'242'424'242,
            .background = 0,
            .reservations = {video_on_mesh, heartbeat}},
           {.name = "uplink",
            .kind = "network",
            .unit = "bytes/s",
            .capacity_known = true,
            .capacity = 300'000,
            .reserved = 400'000,
            .background = 0,
            .reservations = {video}},
           {.name = "bridge",
            .kind = "gateway",
            .unit = "bytes/s",
            .capacity_known = false,
            .capacity = 0,
            .reserved = 160,
            .background = 0,
            .reservations = {}}}};
}

WhatIf full_what_if() {
  const auto outlook = [](const char* channel, bool now, bool then, std::uint32_t set_now,
                          std::uint32_t set_then, const char* reason) {
    return Outlook{.channel = channel,
                   .publisher = "camera",
                   .to = "robot-can",
                   .granted_now = now,
                   .granted_then = then,
                   .set_now = set_now,
                   .set_then = set_then,
                   .reason = reason};
  };
  return {.outlooks = {outlook("map", false, true, 0, 0, "fits"),
                       outlook("sonar", true, true, 2, 0, "fits again"),
                       outlook("video", true, true, 0, 1, "100 kB/s fit"),
                       outlook("speech", true, false, 1, 0, "300 kB/s too much")},
          .unchanged = 12};
}

namespace {

Channel long_channel() {
  auto channel = granted_channel();
  channel.subscribers_left_out = 744;
  channel.rows_left_out = 1745;
  return channel;
}

}  // namespace

/// An answer to an announcement.
static Channels full_announced() {
  return {.channels = {granted_channel()},
          .endpoints = {full_transfers().transfers[0].to},
          .grace_ns = 10'000'000'000,
          .local_problem = "all places are taken"};
}

std::vector<NamedReply> all_replies() {
  const auto error = [](ErrorKind kind) {
    return Reply{
        1, control::Error{.kind = kind, .message = "no", .details = {"a.xml:1: x", "a.xml:2: y"}}};
  };
  return {{"ErrorUnspecified", error(ErrorKind::unspecified)},
          {"ErrorInvalid", error(ErrorKind::invalid)},
          {"ErrorForbidden", error(ErrorKind::forbidden)},
          {"ErrorUnreadable", error(ErrorKind::unreadable)},
          {"ErrorWorld", error(ErrorKind::world)},
          {"Status", {2, full_status()}},
          {"Networks", {3, full_networks()}},
          {"Channels", {4, Channels{{refused_channel(), granted_channel(), switched_channel()}}}},
          {"NoChannels", {4, Channels{}}},
          {"SomeChannels", {4, Channels{{long_channel()}, 99}}},
          {"LeftOut",
           {4, Channels{.admissions_left_out = {{7, "camera", "there is no network lan"},
                                                {8, "0x5600000000000001", "nobody may"}}}}},
          {"Done", {5, Done{"released 1 admission"}}},
          {"Event", {0, full_event()}},
          {"Routes", {6, full_routes()}},
          {"Transfers", {6, full_transfers()}},
          {"Subscriptions", {7, full_subscriptions()}},
          {"Presence", {8, full_presence()}},
          {"RoutesOfPrograms", {6, Routes{{}, {}, {}, {}, full_transfers().transfers, 3}}},
          {"Announced", {6, full_announced()}},
          {"Reservations", {7, full_reservations()}},
          {"Gates", {8, full_gates()}},
          {"WhatIf", {8, full_what_if()}},
          {"Audit", {10, full_audit()}},
          {"Rollout",
           {11, Rollout{.number = 3,
                        .state = "judged",
                        .why = "gw2: line 3: no such network",
                        .waiting = {"gw2"},
                        .description = "01",
                        .current = "02",
                        .former = "03",
                        .next = "04",
                        .by = "gw1",
                        .generation = 7,
                        .open = true}}},
          {"Cluster", {11, full_cluster()}},
          {"ClusterMembers", {12, full_cluster_members()}},
          {"ClusterReservations", {13, full_cluster_reservations()}},
          {"History", {9, full_history()}}};
}

}  // namespace mlcca::test
