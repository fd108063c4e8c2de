// SPDX-License-Identifier: BSD-2-Clause
// Metrics of the cluster: the gateways that share networks through a store.
#include <algorithm>

#include "tools/exporter/exposition.hpp"
#include "tools/exporter/metrics.hpp"

namespace mlcca::exporter {
namespace {

template <class Value>
void add_gauge(std::string_view name, std::string_view help, Value value, std::string& page) {
  Family family(name, "gauge", help);
  family.add(value);
  family.append_to(page);
}

template <class Value>
void add_word(std::string_view name, std::string_view help, std::string_view label,
              const Value& word, std::string& page) {
  Family family(name, "gauge", help);
  family.add(Labels{{label, word}}, true);
  family.append_to(page);
}

}  // namespace

void add_cluster(const control::Cluster& cluster, std::string& page) {
  add_word("mlcca_cluster_phase", "How this gateway stands in its cluster. Always 1.", "phase",
           cluster.phase, page);
  add_word("mlcca_cluster_shared",
           "What may be used of networks of several gateways: open, described, closed. Always 1.",
           "state", cluster.shared, page);
  add_gauge("mlcca_cluster_lasts_seconds", "For how long what is reserved surely lasts.",
            in_seconds(cluster.lasts_ns), page);
  add_gauge("mlcca_cluster_store_up", "Whether the store answers.", cluster.store_up, page);
  if (cluster.store_latency_ns != 0)
    add_gauge("mlcca_cluster_store_latency_seconds", "How long its latest answer took.",
              in_seconds(cluster.store_latency_ns), page);
  if (cluster.store_bytes != 0)
    add_gauge("mlcca_cluster_store_bytes", "Size of the store.", cluster.store_bytes, page);
  add_gauge("mlcca_cluster_store_full", "Whether it takes nothing but deletions.",
            cluster.store_full, page);
  add_gauge("mlcca_cluster_unreadable_entries", "Entries of the store that are not understood.",
            cluster.unreadable, page);
  add_gauge("mlcca_cluster_description_generation",
            "Of the description in force for all gateways; 0: none is.", cluster.generation, page);
  add_gauge("mlcca_cluster_description_same",
            "Whether the description of this gateway is the one in force.",
            !cluster.digest.empty() && cluster.digest == cluster.own_digest, page);
}

void add_members(const control::ClusterMembers& members, const Most& most, LeftOut& left_out,
                 std::string& page) {
  Family member("mlcca_cluster_member", "gauge",
                "State of each gateway of the description: active, taking, standby, draining, "
                "silent, fenced, absent. removed: it is not described, and the store still has "
                "something of it. Always 1.");
  Family age("mlcca_cluster_member_beat_age_seconds", "gauge",
             "Since this gateway has received the latest beat.");
  Family reservations("mlcca_cluster_reservations", "gauge",
                      "What each gateway has reserved of each network, in the store.");
  Family rate("mlcca_cluster_reserved_bytes_per_second", "gauge", "The same, payload.");
  const std::size_t shown = std::min(members.members.size(), most.others);
  left_out["gateways"] = members.members.size() - shown;
  std::size_t shares = 0;
  for (std::size_t i = 0; i < shown; ++i) {
    const control::ClusterMember& one = members.members[i];
    member.add(Labels{{"gateway", one.name}, {"state", one.state}}, true);
    if (one.beats) age.add(Labels{{"gateway", one.name}}, in_seconds(one.beat_age_ns));
    for (const control::ClusterShare& share : one.shares) {
      if (++shares > most.others) continue;
      const Labels labels{{"gateway", one.name}, {"network", share.network}};
      reservations.add(labels, share.reservations);
      rate.add(labels, share.bytes_per_second);
    }
  }
  left_out["shares"] = shares > most.others ? shares - most.others : 0;
  for (const auto* family : {&member, &age, &reservations, &rate}) family->append_to(page);
}

}  // namespace mlcca::exporter
