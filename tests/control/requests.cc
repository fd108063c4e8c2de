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
          .user = "1000",
          .subscriber = "motors",
          .publisher = "switch",
          .from_node = "laptop",
          .to_node = "relay",
          .unlisted = false,
          .identifiers = {},
          .address = "192.0.2.7"};
}

namespace {

Admit full_admit() {
  Admit admit{full_channel_request()};
  admit.key = "camera of robot 7";
  admit.lease_ns = 30'000'000'000;
  admit.hold = true;
  return admit;
}

WhatIfRequest full_what_if_request() {
  return {.links = {{.network = "awds",
                     .from = "laptop",
                     .to = "relay",
                     .rate = 6'000'000,
                     .one_way = false},
                    {.network = "",
                     .from = "02:00:00:00:00:01",
                     .to = "02:00:00:00:00:02",
                     .rate = 0,
                     .one_way = true}},
          .without = {"second-can", "bridge"}};
}

}  // namespace

std::vector<NamedRequest> all_requests() {
  ChannelRequest channel_only;
  channel_only.channel = "a";
  ChannelRequest unlisted;
  unlisted.channel = "0x5600000000000001";
  unlisted.unlisted = true;
  unlisted.identifiers = {{.network = "robot-can", .id = 0x123, .extended = false},
                          {.network = "second-can", .id = 0x1abcdef, .extended = true}};
  return {
      {"Status", {1, StatusRequest{}}},
      {"Networks", {2, NetworksRequest{}}},
      {"Channels", {3, ChannelsRequest{}}},
      {"Query", {4, Query{full_channel_request()}}},
      {"QueryOfChannelOnly", {4, Query{channel_only}}},
      {"QueryOfWhatIsNotDescribed", {4, Query{unlisted}}},
      {"Admit", {5, Admit{full_channel_request()}}},
      {"Release",
       {6, ReleaseRequest{.channel = "emergency-switch", .admission = 9, .key = "blue"}}},
      {"Withdraw", {7, WithdrawRequest{"emergency-switch"}}},
      {"Reinstate", {8, ReinstateRequest{"emergency-switch"}}},
      {"Announce",
       {9,
        AnnounceRequest{"emergency-switch",
                        Role::publisher,
                        "switch",
                        {{.name = "Period", .value = 50'000'000, .unit = "ns", .dynamic = false}},
                        "0a1b2"}}},
      {"Transfers", {9, TransfersRequest{"emergency-switch", 990}}},
      {"Delay",
       {10, DelayRequest{.subject = 0xa4efeccc3210b497,
                         .publisher = "switch",
                         .from = "second-can",
                         .to = "lan",
                         .late = 4,
                         .longest_ns = 9'800'000}}},
      {"Subscriptions", {11, SubscriptionsRequest{}}},
      {"Ping", {11, PingRequest{}}},
      {"Subscribe",
       {12,
        SubscribeRequest{
            .subject = 0xa4efeccc3210b497,
            .network = "lan",
            .source = "192.0.2.7",
            .required = {{.name = "Latency", .value = 7'000'000, .unit = "ns", .dynamic = false}},
            .states_attributes = true,
            .lease_ns = 60'000'000'000,
            .end = true}}},
      {"Refusal",
       {13, RefusalRequest{.subject = 0xa4efeccc3210b497,
                           .network = "lan",
                           .source = "192.0.2.9",
                           .reason = "far to lan: Latency 9 ms"}}},
      {"Presence",
       {14, PresenceRequest{.network = "lan",
                            .gateway = "back-up",
                            .lasts_ns = 3'500'000'000,
                            .forwards = true,
                            .not_received = {"main"}}}},
      {"Explain", {7, ExplainRequest{"0xa4efeccc3210b497"}}},
      {"Monitor", {8, MonitorRequest{}}},
      {"Mode", {9, ModeRequest{"audit", 86'400'000'000'000}}},
      {"Audit", {18, AuditRequest{}}},
      {"Rollout",
       {19, RolloutRequest{.part = std::string("<System\0", 8),
                           .more = true,
                           .without = {"gw3"},
                           .back = true,
                           .accept = true}}},
      {"RolloutState", {20, RolloutStateRequest{}}},
      {"Cluster", {31, ClusterRequest{}}},
      {"ClusterReservations",
       {32, ClusterRequest{.part = "reservations", .network = "lan", .gateway = "gw2"}}},
      {"Drain", {33, DrainRequest{"gw1", true}}},
      {"Join", {34, JoinRequest{"gw1"}}},
      {"Reload", {~std::uint64_t{0}, ReloadRequest{}}},
      {"AdmitWithLease", {10, full_admit()}},
      {"Renew", {11, RenewRequest{.admission = 9, .key = "camera"}}},
      {"Routes", {12, RoutesRequest{}}},
      {"Reservations", {13, ReservationsRequest{"awds"}}},
      {"Gate", {17, GateRequest{"can0"}}},
      {"WhatIf", {14, full_what_if_request()}},
      {"WhatIfNothing", {15, WhatIfRequest{}}},
      {"History",
       {16, HistoryRequest{.channel = "video",
                           .kind = "degraded",
                           .since_unix_ns = 1'700'000'000'000'000'001,
                           .until_unix_ns = 1'800'000'000'000'000'002,
                           .limit = 50}}}};
}

}  // namespace mlcca::test
