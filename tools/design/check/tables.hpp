// SPDX-License-Identifier: BSD-2-Clause
// The tables of the page: each is complete HTML, or empty where there is nothing to show.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "tools/design/check/report.hpp"
#include "tools/design/check/rows.hpp"

namespace mlcca::tools::design {

/// How files are called on the page: as they were named, but an absolute path is relative to the
/// working directory, or else to the folder that all of them have in common.
class FileNames {
 public:
  FileNames(const std::vector<std::string>& files, std::string folder);
  [[nodiscard]] std::string of(const std::string& file) const;

 private:
  std::string folder_;
  std::string common_;  ///< with the slash at its end
};

/// Errors first, then warnings, then notes, each in the order of the report.
std::string findings_tables(const std::vector<ReportedFinding>& findings, const FileNames& names);

/// What does not fit first, then what is decided at run time, then the others. `ways`: the number
/// of each delivery's way in the drawing; `prefix`: of ids.
std::string deliveries_table(const SystemReport& report, const std::vector<std::size_t>& ways,
                             const std::string& prefix);

/// What joins them, what they provide, and what is reserved of a capacity that is stated.
std::string places_table(const SystemReport& report, const std::string& prefix);

std::string user_attributes_table(const core::System& system);

/// Of each CAN bus its load, and the response time of each message against its deadline.
std::string buses_tables(const SystemReport& report);

/// Of each mesh how much of the time of its domains is taken, and may be.
std::string meshes_tables(const SystemReport& report);

}  // namespace mlcca::tools::design
