// SPDX-License-Identifier: BSD-2-Clause
// What a check found, ready to be written: names instead of numbers.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/findings.hpp"
#include "core/inspect.hpp"
#include "core/system.hpp"

namespace mlcca::tools::design {

/// Texts are empty where they do not apply.
struct ReportedFinding {
  core::FindingId id = core::FindingId::rule;
  std::string file;
  int line = 0;         ///< 1.., or 0: the file as a whole
  std::string element;  ///< of the description, for what its rules found
  std::string text;
  std::string hint;
  std::string channel;
  std::string publisher;
  std::string subscriber;
  std::string place;  ///< network or gateway
  std::string attribute;
  std::string required;  ///< with unit
  std::string provided;
};

/// One System with the files that belong to it.
struct SystemReport {
  std::string file;  ///< as it was named on the command line
  bool readable = false;
  bool inspected = false;       ///< names and places are known, so that deliveries could be decided
  core::System system;          ///< empty unless readable
  core::Inspection inspection;  ///< without findings: they are below; empty unless inspected
  std::vector<ReportedFinding> findings;  ///< by file as they appear, line, number
};

struct Totals {
  std::size_t errors = 0;
  std::size_t warnings = 0;
  std::size_t notes = 0;
};

struct Report {
  std::vector<SystemReport> systems;
  std::vector<ReportedFinding> parts;  ///< of files that belong to no System

  [[nodiscard]] Totals totals() const;
  [[nodiscard]] bool readable() const;
};

/// Part of the work that is done, from 0 to 1, in words such as "reading".
using ReportProgress = std::function<void(std::string_view what, double done)>;

/// Checks every file whose root is a System; files with a part as root count as included in each of
/// them, or are held against the schema where there is no System.
Report make_report(const std::vector<std::string>& paths, const ReportProgress& progress);

/// All in one order: those of each system, then those of parts.
void for_each_finding(const Report& report,
                      const std::function<void(const ReportedFinding&)>& each);

/// "error", "warning" or "note".
std::string_view to_text(core::Severity severity);

}  // namespace mlcca::tools::design
