// SPDX-License-Identifier: BSD-2-Clause
// Converts answers of mlccad into metrics.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "tools/exporter/answers.hpp"

namespace mlcca::exporter {

/// At most so many objects get time series of their own; the others are only counted.
struct Most {
  std::size_t deliveries = 2000;
  /// Limit of each other kind: interfaces, networks, resources, links, control traffic, reasons.
  std::size_t others = 512;
};

/// Counters of this program since its start.
struct Past {
  std::uint64_t scrapes = 0;
  std::map<std::string, std::uint64_t> failures;  ///< by name of the request
};

/// The number of objects without series, by kind.
using LeftOut = std::map<std::string, std::size_t>;

/// The complete page. `took_s` is how long the daemon took to answer.
[[nodiscard]] std::string page(const Answers& answers, const Most& most, const Past& past,
                               double took_s);

/// Each of these adds the metrics of a part. The state is `unknown` if the daemon did not answer.
void add_health_state(control::HealthState state, std::string& page);
void add_status(const control::Status& status, const Most& most, LeftOut& left_out,
                std::string& page);
void add_networks(const Reports& reports, const Most& most, LeftOut& left_out, std::string& page);
void add_gates(const control::Gates& gates, const Most& most, LeftOut& left_out, std::string& page);
void add_deliveries(const control::Channels& channels, const Most& most, LeftOut& left_out,
                    std::string& page);
void add_cluster(const control::Cluster& cluster, std::string& page);
void add_members(const control::ClusterMembers& members, const Most& most, LeftOut& left_out,
                 std::string& page);

/// A reason without what changes while it holds or what any sender may choose: otherwise each new
/// number, and each new sender, would create another time series. It has "N" in place of numbers,
/// addresses and subjects, and ends before what was seen latest.
[[nodiscard]] std::string kind_of(std::string_view reason);

}  // namespace mlcca::exporter
