// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/check/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <tuple>
#include <unordered_set>
#include <utility>

#include "core/design/bus_responses.hpp"
#include "core/model/members.hpp"
#include "core/model/text.hpp"
#include "description/read.hpp"

namespace mlcca::tools::design {
namespace {

using core::FindingId;

constexpr double kReadingShare = 0.6;  // share of the total work

/// After these findings the System lacks what others would be compared with.
bool hides_others(FindingId id) {
  switch (id) {
    case FindingId::not_in_schema:
    case FindingId::rule:
    case FindingId::unknown_name:
    case FindingId::wrong_place:
    case FindingId::unplaced:
    case FindingId::too_many:
      return true;
    default:
      return false;
  }
}

ReportedFinding reported(const description::Problem& problem) {
  ReportedFinding out;
  out.id = problem.id;
  out.file = problem.file;
  out.line = problem.line;
  out.element = problem.element;
  out.text = problem.text;
  return out;
}

ReportedFinding reported(const core::System& system, core::Finding& finding) {
  ReportedFinding out;
  out.id = finding.id;
  if (finding.origin.file < system.files.size()) out.file = system.files[finding.origin.file];
  out.line = finding.origin.line;
  out.text = std::move(finding.text);
  out.hint = std::move(finding.hint);
  if (finding.channel != core::kNone) out.channel = system.channels[finding.channel].name;
  if (finding.publisher != core::kNone) out.publisher = system.publishers[finding.publisher].name;
  if (finding.subscriber != core::kNone)
    out.subscriber = system.subscribers[finding.subscriber].name;
  if (finding.has_place) out.place = core::name_of(system, finding.place);
  out.attribute = std::move(finding.attribute);
  out.required = std::move(finding.required);
  out.provided = std::move(finding.provided);
  return out;
}

/// The findings about the rules of the description, by line.
class RuleFindings {
 public:
  explicit RuleFindings(const std::vector<ReportedFinding>& all) {
    for (const ReportedFinding& f : all) found_.emplace(f.id, f.file, f.line);
  }
  /// Whether the same finding is stated already about an end that `finding` concerns.
  [[nodiscard]] bool state(const core::System& system, const core::Finding& finding) const {
    if (found_.empty()) return false;
    const auto at = [&](const core::Origin& origin) {
      return origin.file < system.files.size() &&
             found_.contains({finding.id, system.files[origin.file], origin.line});
    };
    return (finding.publisher != core::kNone && at(system.publishers[finding.publisher].origin)) ||
           (finding.subscriber != core::kNone && at(system.subscribers[finding.subscriber].origin));
  }

 private:
  std::set<std::tuple<FindingId, std::string, int>> found_;
};

/// Sorts by file (in the order of reading) and line, and otherwise keeps the order.
void sort_findings(const core::System& system, std::vector<ReportedFinding>& findings) {
  const auto number = [&](const ReportedFinding& f) {
    return std::ranges::find(system.files, f.file) - system.files.begin();
  };
  std::ranges::stable_sort(findings, [&](const ReportedFinding& a, const ReportedFinding& b) {
    if (a.file != b.file) return number(a) < number(b);
    return a.line < b.line;
  });
}

core::Inspection decide(SystemReport& report, const core::InspectProgress& progress, Depth depth) {
  if (depth == Depth::findings) return core::inspect(report.system, progress);
  const core::Members members(report.system);
  std::vector<bool> known(report.system.channels.size(), false);
  auto inspection = core::inspect(
      report.system, progress,
      [&](std::size_t channel, const core::Decision& decision, std::span<const core::Finding>) {
        // The set in use comes first; the others are skipped.
        if (known[channel]) return;
        known[channel] = true;
        for (const core::Verdict& verdict : decision.verdicts)
          report.deliveries.push_back(in_words(report.system, members, verdict));
      },
      &report.buses);
  std::vector<core::SentMessage> sent;
  for (std::size_t n = 0; n < report.buses.assumptions.size(); ++n)
    std::ranges::copy(core::sent_beside(report.buses, n), std::back_inserter(sent));
  std::map<std::size_t, std::vector<const core::SentMessage*>> by_publisher;
  for (const core::SentMessage& one : sent) by_publisher[one.message->publisher].push_back(&one);
  for (ReportedDelivery& d : report.deliveries)
    if (const auto own = by_publisher.find(d.publisher_number); own != by_publisher.end())
      consider(report.system, own->second, d);
  std::ranges::stable_sort(report.deliveries, {}, &ReportedDelivery::channel);
  return inspection;
}

SystemReport check_system(const std::vector<std::string>& paths, const ReportProgress& progress,
                          Depth depth) {
  SystemReport out;
  out.file = paths.front();
  const auto say = [&](std::string_view what, double done) {
    if (progress) progress(what, done);
  };
  auto examined = description::examine(
      paths,
      [&](std::uint64_t read, std::uint64_t total) {
        say("reading", total == 0 ? 0 : kReadingShare * double(read) / double(total));
      },
      description::Users::any);
  out.readable = examined.readable;
  out.system = std::move(examined.system);
  for (const auto& problem : examined.problems) out.findings.push_back(reported(problem));
  out.usable = out.readable && out.findings.empty();
  out.inspected =
      out.readable && std::ranges::none_of(out.findings, hides_others, &ReportedFinding::id);
  if (!out.inspected) return out;
  out.system.sort_bindings();
  const auto all = static_cast<double>(std::max<std::size_t>(out.system.channels.size(), 1));
  const auto progressed = [&](std::size_t done) {
    say("checking", kReadingShare + (1 - kReadingShare) * static_cast<double>(done) / all);
  };
  out.inspection = decide(out, progressed, depth);
  const bool problems = !out.findings.empty();
  const RuleFindings by_rules(out.findings);
  for (auto& finding : std::exchange(out.inspection.findings, {}))
    if (!by_rules.state(out.system, finding)) out.findings.push_back(reported(out.system, finding));
  if (problems) sort_findings(out.system, out.findings);
  return out;
}

}  // namespace

Totals Report::totals() const {
  Totals totals;
  for_each_finding(*this, [&](const ReportedFinding& f) {
    switch (core::info(f.id).severity) {
      case core::Severity::error:
        ++totals.errors;
        break;
      case core::Severity::warning:
        ++totals.warnings;
        break;
      case core::Severity::note:
        ++totals.notes;
        break;
    }
  });
  return totals;
}

bool Report::readable() const {
  return parts.empty() && std::ranges::all_of(systems, &SystemReport::readable);
}

std::vector<std::string> Report::files() const {
  std::vector<std::string> out;
  std::unordered_set<std::string_view> known;
  const auto add = [&](const std::string& file) {
    if (!file.empty() && known.insert(file).second) out.push_back(file);
  };
  for (const auto& system : systems)
    for (const auto& file : system.system.files) add(file);
  for (const auto& file : part_files) add(file);
  for (const auto& finding : parts) add(finding.file);
  return out;
}

Exit status_of(const Report& report) {
  if (!report.readable()) return Exit::usage;
  const auto totals = report.totals();
  return totals.errors + totals.warnings == 0 ? Exit::fine : Exit::refused;
}

ChannelCounts counts_of(const SystemReport& system) {
  ChannelCounts counts;
  for (const auto& channel : system.inspection.channels) {
    if (channel.outcome == Outcome::fit && channel.deliveries == 0)
      ++counts.unused;
    else if (channel.outcome == Outcome::fit)
      ++counts.fit;
    else if (channel.outcome == Outcome::run_time)
      ++counts.run_time;
    else
      ++counts.unfit;
  }
  return counts;
}

Report make_report(const std::vector<std::string>& paths, const ReportProgress& progress,
                   Depth depth) {
  Report report;
  std::vector<std::string> systems;
  std::vector<std::string> parts;
  for (const auto& path : paths) {
    auto& group = description::is_part(path) ? parts : systems;
    if (std::ranges::find(group, path) == group.end()) group.push_back(path);
  }
  for (const auto& path : systems) {
    std::vector<std::string> together{path};
    together.insert(together.end(), parts.begin(), parts.end());
    report.systems.push_back(check_system(together, progress, depth));
  }
  if (!systems.empty()) return report;
  report.part_files = parts;
  for (const auto& path : parts)
    for (const auto& problem : description::check_part(path))
      report.parts.push_back(reported(problem));
  return report;
}

void for_each_finding(const Report& report,
                      const std::function<void(const ReportedFinding&)>& each) {
  for (const auto& system : report.systems)
    for (const auto& finding : system.findings) each(finding);
  for (const auto& finding : report.parts) each(finding);
}

std::string_view to_text(core::Severity severity) {
  switch (severity) {
    case core::Severity::error:
      return "error";
    case core::Severity::warning:
      return "warning";
    case core::Severity::note:
      break;
  }
  return "note";
}

}  // namespace mlcca::tools::design
