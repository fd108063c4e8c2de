// SPDX-License-Identifier: BSD-2-Clause
#include <fmt/format.h>

#include <iterator>

#include "base/many.hpp"
#include "description/kinds.hpp"
#include "tools/design/check/write.hpp"

namespace mlcca::tools::design {
namespace {

Style style_of(core::Severity severity) {
  switch (severity) {
    case core::Severity::error:
      return Style::bad;
    case core::Severity::warning:
      return Style::warning;
    case core::Severity::note:
      break;
  }
  return Style::dim;
}

void write(std::string& out, const ReportedFinding& f, Color color) {
  out += line_of(f, color) + "\n";
  if (!f.hint.empty())
    fmt::format_to(std::back_inserter(out), "    {}\n",
                   styled("hint: " + f.hint, Style::dim, color));
}

/// "volksbot: 3 channels: 2 fit, 1 decided at run time, 0 do not fit". If mlccad would refuse the
/// description, nothing fits, and the counts are those of the deliveries alone.
std::string channels_line(const SystemReport& system) {
  const auto& name = system.system.name.empty() ? system.file : system.system.name;
  if (!system.readable) return fmt::format("{}: cannot be read", name);
  if (!system.inspected)
    return fmt::format("{}: deliveries are checked when the names and rules are right", name);
  const auto counts = counts_of(system);
  return fmt::format(
      "{}: {}{}: {} {}, {} decided at run time, {} do not fit{}", name,
      system.usable ? "" : "not usable for these errors; its deliveries by themselves: ",
      many(system.inspection.channels.size(), "channel"), counts.fit,
      system.usable ? "fit" : "would fit", counts.run_time, counts.unfit,
      counts.unused == 0 ? "" : fmt::format(", {} without use", counts.unused));
}

}  // namespace

std::string line_of(const ReportedFinding& f, Color color) {
  const auto& info = core::info(f.id);
  std::string where = f.file;
  if (f.line > 0) where += fmt::format(":{}", f.line);
  const auto what = fmt::format("{} {}:", to_text(info.severity), core::code_of(f.id));
  return fmt::format("{}: {} {}{}", styled(where, Style::bold, color),
                     styled(what, style_of(info.severity), color),
                     f.element.empty() ? "" : printable("<" + f.element + ">: "),
                     printable(f.text));
}

std::string write_text(const Report& report, Color color) {
  std::string out;
  for (const auto& system : report.systems)
    for (const auto& f : description::shortened(system.findings)) write(out, f, color);
  for (const auto& f : description::shortened(report.parts)) write(out, f, color);
  for (const auto& system : report.systems) out += printable(channels_line(system)) + "\n";
  const auto totals = report.totals();
  if (totals.errors + totals.warnings + totals.notes != 0)
    out += fmt::format("{}, {}, {}\n", many(totals.errors, "error"),
                       many(totals.warnings, "warning"), many(totals.notes, "note"));
  else if (report.systems.empty())
    out += "no problems: each part fits the schema\n";
  return out;
}

}  // namespace mlcca::tools::design
