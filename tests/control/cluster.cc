// SPDX-License-Identifier: BSD-2-Clause
#include "tests/control/messages.hpp"

namespace mlcca::test {

using namespace control;

namespace {

const std::string kDigest = "1f0c" + std::string(60, 'a');
const std::string kOther = "2e1d" + std::string(60, 'b');

ClusterMember without_beats(const char* name, const char* state) {
  ClusterMember out;
  out.name = name;
  out.state = state;
  return out;
}

ClusterMember removed() {
  ClusterMember out = without_beats("gw9", "removed");
  out.entries = 2;
  out.removal = "etcdctl del /mlcca/robots/m/gw9 && etcdctl del /mlcca/robots/f/gw9";
  return out;
}

}  // namespace

Cluster full_cluster() {
  return {.gateway = "gw1",
          .system = "robots",
          .phase = "other-description",
          .why = "the description in force is another one",
          .shared = "closed",
          .networks = {"can-arm", "mesh"},
          .health = {.state = HealthState::closed,
                     .reasons = {"cluster robots: networks of several gateways are closed: the "
                                 "description in force is another one"},
                     .left_out = 1},
          .incarnation = 41,
          .epoch = "000102030405060708090a0b0c0d0e0f",
          .lease_ns = 10'000'000'000,
          .lasts_ns = 8'250'000'000,
          .generation = 3,
          .digest = kDigest,
          .in_force = true,
          .own_digest = kOther,
          .store_up = true,
          .store_for_ns = 245'000'000'000,
          .store_endpoint = "https://10.0.0.1:2379",
          .store_problem = "it was slow",
          .store_latency_ns = 2'300'000,
          .store_bytes = 24'576,
          .store_full = true,
          .gateways = 3,
          .present = 2,
          .reservations = 5,
          .unreadable = 1};
}

ClusterMembers full_cluster_members() {
  return {.gateway = "gw1",
          .system = "robots",
          .members = {{.name = "gw1",
                       .own = true,
                       .state = "active",
                       .incarnation = 41,
                       .beats = true,
                       .beat_age_ns = 1'200'000'000,
                       .lease_ns = 10'000'000'000,
                       .lasts_ns = 8'250'000'000,
                       .digest = kDigest,
                       .generation = 3,
                       .other = false,
                       .beside = {"gw2"},
                       .carries = {"video", "odometry"},
                       .carries_left_out = 7,
                       .shares = {{.network = "can-arm",
                                   .reservations = 2,
                                   .bytes_per_second = 320,
                                   .messages = 2},
                                  {.network = "mesh",
                                   .reservations = 1,
                                   .bytes_per_second = 400'000,
                                   .messages = 0}}},
                      {.name = "gw2",
                       .own = false,
                       .state = "silent",
                       .incarnation = 17,
                       .beats = true,
                       .beat_age_ns = 75'000'000'000,
                       .lease_ns = 10'000'000'000,
                       .lasts_ns = 0,
                       .digest = kOther,
                       .generation = 0,
                       .other = true,
                       .beside = {"gw1"},
                       .carries = {},
                       .carries_left_out = 0,
                       .shares = {}},
                      without_beats("gw3", "absent"),
                      removed()}};
}

ClusterReservations full_cluster_reservations() {
  return {.gateway = "gw1",
          .system = "robots",
          .reservations = {{.network = "can-arm",
                            .gateway = "gw1",
                            .number = 7,
                            .channel = "grip",
                            .publisher = "lever",
                            .state = "granted",
                            .bytes_per_second = 160,
                            .messages = 1,
                            .paths = 0,
                            .through = {}},
                           {.network = "can-arm",
                            .gateway = "gw2",
                            .number = ~std::uint64_t{0},
                            .channel = {},
                            .publisher = {},
                            .state = "unreadable",
                            .bytes_per_second = 0,
                            .messages = 0,
                            .paths = 0,
                            .through = {}},
                           {.network = "mesh",
                            .gateway = "gw1",
                            .number = 8,
                            .channel = "video",
                            .publisher = "camera",
                            .state = "pending",
                            .bytes_per_second = 400'000,
                            .messages = 0,
                            .paths = 2,
                            .through = {"gw2", "gw3"}},
                           {.network = "mesh",
                            .gateway = "gw2",
                            .number = 9,
                            .channel = "map",
                            .publisher = "laser",
                            .state = "ending",
                            .bytes_per_second = 25,
                            .messages = 0,
                            .paths = 1,
                            .through = {}}}};
}

}  // namespace mlcca::test
