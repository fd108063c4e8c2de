// SPDX-License-Identifier: BSD-2-Clause
// What a check found, ready to be written: names instead of numbers.
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
  bool usable = false;          ///< no rule of descriptions is broken: mlccad would take it
  bool inspected = false;       ///< names and places are known, so that deliveries could be decided
  core::System system;          ///< only its files unless readable
  core::Inspection inspection;  ///< without findings: they are below; empty unless inspected
  std::vector<ReportedFinding> findings;  ///< by file as they appear, line, number
  /// With Depth::deliveries: by channel, each in the attribute set that is used.
  std::vector<ReportedDelivery> deliveries;
  core::InspectedBuses buses;
};

struct Totals {
  std::size_t errors = 0;
  std::size_t warnings = 0;
  std::size_t notes = 0;
};

/// The channels of a system by what became of them.
struct ChannelCounts {
  std::size_t fit = 0;
  std::size_t run_time = 0;
  std::size_t unfit = 0;
  std::size_t unused = 0;  ///< nothing to decide: nobody publishes, or nobody subscribes
};

struct Report {
  std::vector<SystemReport> systems;
  std::vector<std::string> part_files;  ///< that belong to no System
  std::vector<ReportedFinding> parts;   ///< what is wrong with them

  [[nodiscard]] Totals totals() const;
  [[nodiscard]] bool readable() const;
  /// Every file that was read, or should have been, each once, in the order in which they appear.
  [[nodiscard]] std::vector<std::string> files() const;
};

/// Part of the work that is done, from 0 to 1, in words such as "reading".
using ReportProgress = std::function<void(std::string_view what, double done)>;

/// What a report has beside findings and counts; more takes longer.
enum class Depth : std::uint8_t { findings, deliveries };

/// Checks every file whose root is a System; files with a part as root count as included in each of
/// them, or are held against the schema where there is no System. A path that is given twice counts
/// once.
Report make_report(const std::vector<std::string>& paths, const ReportProgress& progress,
                   Depth depth = Depth::findings);

/// fine (notes do not count), refused (errors or warnings), or usage (a file cannot be read).
[[nodiscard]] Exit status_of(const Report& report);

[[nodiscard]] ChannelCounts counts_of(const SystemReport& system);

/// All in one order: those of each system, then those of parts.
void for_each_finding(const Report& report,
                      const std::function<void(const ReportedFinding&)>& each);

/// "error", "warning" or "note".
std::string_view to_text(core::Severity severity);

}  // namespace mlcca::tools::design
