// SPDX-License-Identifier: BSD-2-Clause
#include "tests/control/messages.hpp"

namespace mlcca::test {

using namespace control;

ChannelRequest full_channel_request() {
  return {.channel = "emergency-switch",
          .from = "second-can",
          .to = "robot-can",
          .offered = {{.name = "Period", .value = 50'000'000, .unit = "ns", .dynamic = false},
                      {.name = "MaxPayload", .value = 8, .unit = "bytes", .dynamic = false}},
          .required = {{.name = "Omission", .value = 2, .unit = "events", .dynamic = true}},
          .node = 0,  // present, and the default of the wire
          .priority = 125,
          .user = "robot",
          .subscriber = "motors",
          .publisher = "switch"};
}

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
          .reaction = {}};
}

Channel granted_channel() {
  auto channel = refused_channel();
  channel.from = "robot-can";
  channel.granted = true;
  channel.reason = "Period 50 ms required, the route provides 12.5 ms (37.5 ms to spare)";
  channel.route = {"robot-can"};
  channel.rows.resize(1);
  channel.rows[0].where = "robot-can";
  channel.admission = 7;
  channel.dropped = 0;
  channel.reaction = "174 ms = (Omission 2 + 1) x Period 50 ms + Latency 12 ms + Jitter 12 ms";
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
      .gated = true,
      .slots = 4,
      .ingress = {.passed = 1001,
                  .dropped = 22,
                  .unknown = 21,
                  .reasons = {{"unknown", 21}, {"length", 1}}},
      .egress = {.passed = 2002, .dropped = 33, .unknown = 30, .reasons = {{"source", 3}}},
      .unknown = {{.can_id = 0x98ffa533, .length = 8, .fd = false, .egress = false, .frames = 19},
                  {.can_id = 0x123, .length = 64, .fd = true, .egress = true, .frames = 2}},
      .problem = "queue is full"};
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
          .last_error = "system.xml:7: <Period>: not a number",
          .interfaces = {can0, can1},
          .problem = "can1 is missing"};
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
            .gateways = {"bridge", "second-bridge"}},
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
          .message = "Omission 2 required, bridge provides 5"};
}

std::vector<NamedRequest> all_requests() {
  ChannelRequest channel_only;
  channel_only.channel = "a";
  return {{"Status", {1, StatusRequest{}}},
          {"Networks", {2, NetworksRequest{}}},
          {"Channels", {3, ChannelsRequest{}}},
          {"Query", {4, Query{full_channel_request()}}},
          {"QueryOfChannelOnly", {4, Query{channel_only}}},
          {"Admit", {5, Admit{full_channel_request()}}},
          {"Release", {6, ReleaseRequest{.channel = "emergency-switch", .admission = 9}}},
          {"Explain", {7, ExplainRequest{"0xa4efeccc3210b497"}}},
          {"Monitor", {8, MonitorRequest{}}},
          {"Mode", {9, ModeRequest{"audit"}}},
          {"Reload", {~std::uint64_t{0}, ReloadRequest{}}}};
}

std::vector<NamedReply> all_replies() {
  const auto error = [](ErrorKind kind) {
    return Reply{1, Error{.kind = kind, .message = "no", .details = {"a.xml:1: x", "a.xml:2: y"}}};
  };
  return {{"ErrorUnspecified", error(ErrorKind::unspecified)},
          {"ErrorInvalid", error(ErrorKind::invalid)},
          {"ErrorForbidden", error(ErrorKind::forbidden)},
          {"ErrorUnreadable", error(ErrorKind::unreadable)},
          {"ErrorWorld", error(ErrorKind::world)},
          {"Status", {2, full_status()}},
          {"Networks", {3, full_networks()}},
          {"Channels", {4, Channels{{refused_channel(), granted_channel()}}}},
          {"NoChannels", {4, Channels{}}},
          {"Done", {5, Done{"released 1 admission"}}},
          {"Event", {0, full_event()}}};
}

}  // namespace mlcca::test
