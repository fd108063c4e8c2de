// SPDX-License-Identifier: BSD-2-Clause
#include "tests/control/messages.hpp"

namespace mlcca::test {

using namespace control;

Transfers full_transfers() {
  return {{{.subject = 0xa4efeccc3210b497,
            .channel = "emergency-switch",
            .publisher = "switch",
            .from = {.network = "second-can",
                     .interface = "can1",
                     .ifindex = 4,
                     .can = true,
                     .id = 0x9f480064,
                     .mask = 0xdfffffff,
                     .classic = true,
                     .fd = true,
                     .profile = "famouso",
                     .frame_bytes = 8,
                     .fragmented = true,
                     .address = "",
                     .local = "",
                     .user = {}},
            .to = {.network = "lan",
                   .interface = "eth0",
                   .ifindex = 2,
                   .can = false,
                   .id = 0,
                   .mask = 0,
                   .classic = false,
                   .fd = false,
                   .profile = "famouso",
                   .frame_bytes = 8183,
                   .fragmented = false,
                   .address = "192.0.2.7",
                   .local = "0a1b2",
                   .user = 1000},
            .event_bytes = 24'608,
            .period_ns = 50'000'000,
            .user = 990,
            .latency_ns = 1'000'000}}};
}

Subscriptions full_subscriptions() {
  const Endpoint endpoint = full_transfers().transfers[0].from;
  return {{{.network = "second-can",
            .accepts_all = true,
            .most = 64,
            .endpoint = endpoint,
            .problem = "the tag of SUBSCRIB is not known yet",
            .user = 991,
            .gateways_only = false}},
          {{.subject = 0xa4efeccc3210b497,
            .channel = "emergency-switch",
            .network = "second-can",
            .required = {{.name = "Deadline", .value = 43'000'000, .unit = "ns", .dynamic = false}},
            .problem = "it requires a user-defined attribute"}}};
}

Presence full_presence() {
  return {.gateway = "main",
          .interval_ns = 500'000'000,
          .lasts_ns = ~std::uint64_t{0},
          .forwards = true,
          .not_received = {"back-up"},
          .others = {"back-up", "third"},
          .networks = {"lan", "second-can"}};
}

}  // namespace mlcca::test
