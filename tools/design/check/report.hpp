// SPDX-License-Identifier: BSD-2-Clause
// The result of a check with names instead of indices, ready for output.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/design/findings.hpp"
#include "core/design/inspect.hpp"
#include "core/model/system.hpp"
#include "tools/design/check/deliveries.hpp"
#include "tools/exit.hpp"

namespace mlcca::tools::design {

/// A finding. A text that does not apply is empty.
struct ReportedFinding {
  core::FindingId id = core::FindingId::rule;
  std::string file;
  int line = 0;         ///< from 1; 0: the finding is about the file
  std::string element;  ///< name of the XML element, for findings about the description itself
  std::string text;
  std::string hint;
  std::string channel;
  std::string publisher;
  std::string subscriber;
  std::string place;  ///< name of a network or gateway
  std::string attribute;
  std::string required;  ///< value with its unit
  std::string provided;
};

/// The result for one System with its files.
struct SystemReport {
  std::string file;  ///< the path as given on the command line
  bool readable = false;
  bool usable = false;          ///< it breaks no rule of descriptions, so mlccad would accept it
  bool inspected = false;       ///< names and places are resolved, so deliveries could be decided
  core::System system;          ///< contains only its files unless `readable`
  core::Inspection inspection;  ///< without findings, which are in the next member; empty unless
                                ///< `inspected`
  std::vector<ReportedFinding> findings;  ///< sorted by file in the order of reading, line, and
                                          ///< number
  /// With Depth::deliveries: the deliveries by channel, each in the attribute set in use.
  std::vector<ReportedDelivery> deliveries;
  core::InspectedBuses buses;
};

/// The numbers of findings by severity.
struct Totals {
  std::size_t errors = 0;
  std::size_t warnings = 0;
  std::size_t notes = 0;
};

/// The numbers of channels of a system by their outcome.
struct ChannelCounts {
  std::size_t fit = 0;
  std::size_t run_time = 0;
  std::size_t unfit = 0;
  std::size_t unused = 0;  ///< nothing to decide, because there is no publisher or no subscriber
};

/// The result of a check of several files.
struct Report {
  std::vector<SystemReport> systems;
  std::vector<std::string> part_files;  ///< files that belong to no System
  std::vector<ReportedFinding> parts;   ///< findings in those files

  [[nodiscard]] Totals totals() const;
  [[nodiscard]] bool readable() const;
  /// Every file that was or should have been read, once each, in the order of the report.
  [[nodiscard]] std::vector<std::string> files() const;
};

/// Reports progress: `done` is from 0 to 1, `what` is a word such as "reading".
using ReportProgress = std::function<void(std::string_view what, double done)>;

/// How much a report contains; `deliveries` takes longer.
enum class Depth : std::uint8_t { findings, deliveries };

/// Checks every file whose root is a System. A file with a part as root counts as included in each
/// System; if there is none it is only validated against the schema. A path that is given twice
/// counts once.
Report make_report(const std::vector<std::string>& paths, const ReportProgress& progress,
                   Depth depth = Depth::findings);

/// Exit::fine (notes do not count), refused (errors or warnings) or usage (a file cannot be read).
[[nodiscard]] Exit status_of(const Report& report);

[[nodiscard]] ChannelCounts counts_of(const SystemReport& system);

/// Calls `each` for the findings of each system, then for those of parts.
void for_each_finding(const Report& report,
                      const std::function<void(const ReportedFinding&)>& each);

/// "error", "warning" or "note".
std::string_view to_text(core::Severity severity);

}  // namespace mlcca::tools::design
