// SPDX-License-Identifier: BSD-2-Clause
// What mlccad says, as metrics.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "tools/exporter/answers.hpp"

namespace mlcca::exporter {

/// Of which so many get series of their own; the others are counted.
struct Most {
  std::size_t deliveries = 2000;
  /// Of each other kind: interfaces, networks, resources, links, control traffic, reasons.
  std::size_t others = 512;
};

/// Of this program since it was started.
struct Past {
  std::uint64_t scrapes = 0;
  std::map<std::string, std::uint64_t> failures;  ///< by request
};

/// What was left out, by kind.
using LeftOut = std::map<std::string, std::size_t>;

/// The whole page. `took_s`: how long the daemon was asked.
[[nodiscard]] std::string page(const Answers& answers, const Most& most, const Past& past,
                               double took_s);

/// What each part of it adds.
void add_status(const control::Status& status, const Most& most, LeftOut& left_out,
                std::string& page);
void add_networks(const Reports& reports, const Most& most, LeftOut& left_out, std::string& page);
void add_gates(const control::Gates& gates, const Most& most, LeftOut& left_out, std::string& page);
void add_deliveries(const control::Channels& channels, const Most& most, LeftOut& left_out,
                    std::string& page);
void add_cluster(const control::Cluster& cluster, std::string& page);
void add_members(const control::ClusterMembers& members, const Most& most, LeftOut& left_out,
                 std::string& page);

/// A reason in which "N" stands for each number that stands alone: what counts frames or seconds
/// would be another time series with each scrape.
[[nodiscard]] std::string without_numbers(std::string_view reason);

}  // namespace mlcca::exporter
