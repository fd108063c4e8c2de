// SPDX-License-Identifier: BSD-2-Clause
// The tables of the page. Each function returns complete HTML, or an empty text if there is nothing
// to show.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "tools/design/check/report.hpp"
#include "tools/design/check/rows.hpp"

namespace mlcca::tools::design {

/// Short names of files on the page: the path as given; an absolute path is made relative to the
/// working directory (`folder`) or to the folder that all files have in common.
class FileNames {
 public:
  FileNames(const std::vector<std::string>& files, std::string folder);
  /// The short name of one of the files.
  [[nodiscard]] std::string of(const std::string& file) const;

 private:
  std::string folder_;
  std::string common_;  ///< with its final slash
};

/// Errors, then warnings, then notes, each in the order of the report.
std::string findings_tables(const std::vector<ReportedFinding>& findings, const FileNames& names);

/// What does not fit, then what is decided at run time, then the rest. `ways` is Map::way_of;
/// `prefix` makes the ids of HTML elements unique.
std::string deliveries_table(const SystemReport& report, const std::vector<std::size_t>& ways,
                             const std::string& prefix);

/// The networks and gateways: what joins them, what they provide, and how much of a stated capacity
/// is reserved.
std::string places_table(const SystemReport& report, const std::string& prefix);

std::string user_attributes_table(const core::System& system);

/// For each CAN bus its load and the response time of each message against its deadline.
std::string buses_tables(const SystemReport& report);

/// For each mesh how much time of its contention domains is reserved, and the limit.
std::string meshes_tables(const SystemReport& report);

}  // namespace mlcca::tools::design
