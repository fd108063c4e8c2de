// SPDX-License-Identifier: BSD-2-Clause
// One page without scripts and without anything from elsewhere; what the description says is text.
#include <fmt/format.h>

#include <iterator>

#include "control/version.hpp"
#include "tools/design/check/drawing.hpp"
#include "tools/design/check/graphviz.hpp"
#include "tools/design/check/tables.hpp"
#include "tools/design/check/write.hpp"
#include "tools/escape.hpp"

namespace mlcca::tools::design {
namespace {

// The policy holds even if a text were not escaped: nothing is loaded, nothing runs.
constexpr std::string_view kHead = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'">
<meta name="viewport" content="width=device-width, initial-scale=1">
)";

constexpr std::string_view kStyle = R"(<style>
:root { color-scheme: light dark; --text: #1f2328; --back: #ffffff; --line: #d0d7de;
  --soft: #57606a; --good: #1a7f37; --maybe: #b26a00; --bad: #c62828; }
@media (prefers-color-scheme: dark) { :root { --text: #e6edf3; --back: #0d1117; --line: #30363d;
  --soft: #9198a1; --good: #3fb950; --maybe: #e3a008; --bad: #ff7b72; } }
body { color: var(--text); background: var(--back); font: 15px/1.45 system-ui, sans-serif;
  margin: 2rem auto; max-width: 72rem; padding: 0 1rem; }
h1 { margin-bottom: .2rem; } h2 { margin-top: 2.5rem; border-bottom: 1px solid var(--line); }
table { border-collapse: collapse; width: 100%; margin: .5rem 0 1.5rem; }
th, td { text-align: left; vertical-align: top; padding: .3rem .6rem;
  border-bottom: 1px solid var(--line); overflow-wrap: anywhere; }
td:first-child { white-space: nowrap; }
code { font-family: ui-monospace, monospace; font-size: .92em; }
.hint, .more, footer { color: var(--soft); } .hint { margin: .2rem 0 0; }
.counts b { margin-right: .2rem; } .counts span { margin-right: 1.2rem; }
tr.fit td:nth-child(4), .good { color: var(--good); }
tr.run-time td:nth-child(4), .maybe { color: var(--maybe); }
tr.unfit td:nth-child(4), .bad { color: var(--bad); font-weight: 600; }
.bar { display: inline-block; width: 8rem; height: .7rem; border: 1px solid var(--soft); }
.bar span { display: block; height: 100%; background: var(--soft); }
figure { margin: 1rem 0; overflow-x: auto; } figure svg { max-width: 100%; height: auto; }
svg text { fill: var(--text); }
svg .network ellipse, svg .gateway polygon, svg .end path { stroke: var(--text); }
svg .fit path, svg .fit polygon { stroke: var(--good); } svg .fit polygon { fill: var(--good); }
svg .run-time path, svg .run-time polygon { stroke: var(--maybe); }
svg .run-time polygon { fill: var(--maybe); }
svg .unfit path, svg .unfit polygon, svg .unfit polyline { stroke: var(--bad); }
svg .unfit polygon { fill: var(--bad); }
@media print { body { margin: 0; max-width: none; } tr, figure { break-inside: avoid; } }
</style>
)";

constexpr std::string_view kLegend =
    "<figcaption><span class=\"good\">━━▶ solid green: fits</span> · "
    "<span class=\"maybe\">╍╍▶ dashed amber: decided at run time</span> · "
    "<span class=\"bad\">┅┅┤ dotted red with a bar: does not fit</span> · "
    "dashed outline and the word dynamic: states best cases only";

std::string summary(std::string_view title, const SystemReport& system) {
  if (!system.readable)
    return fmt::format("<p class=\"bad\">{} cannot be read: repair the errors first.</p>\n", title);
  if (!system.inspected)
    return "<p class=\"bad\">The deliveries are checked when the names and rules are right.</p>\n";
  const auto counts = counts_of(system);
  const char* const refused =
      system.usable
          ? ""
          : "<p class=\"bad\">The description is not usable for the errors below. Without "
            "them:</p>\n";
  return fmt::format(
      "{}<p class=\"counts\"><span><b>{}</b>:</span><span class=\"good\"><b>{}</b> fit</span>"
      "<span class=\"maybe\"><b>{}</b> decided at run time</span>"
      "<span class=\"bad\"><b>{}</b> do not fit</span></p>\n",
      refused, counted(system.inspection.channels.size(), "channel"), counts.fit, counts.run_time,
      counts.unfit);
}

std::string figure(const SystemReport& system, std::size_t number) {
  const auto drawing = draw(system, number);
  const auto svg = draw_svg(drawing.source);
  if (!svg)
    return fmt::format("<p class=\"more\">There is no drawing: {}.</p>\n",
                       html_text(svg.error().text));
  auto out = fmt::format("<figure>\n{}{}", *svg, kLegend);
  if (drawing.aggregated)
    out += " · an edge stands for all channels of one outcome between two places";
  if (drawing.left_out != 0) out += fmt::format(" · {} more parts are not drawn", drawing.left_out);
  return out + "</figcaption>\n</figure>\n";
}

std::string findings(const std::vector<ReportedFinding>& all) {
  std::string out;
  for (const auto severity : {core::Severity::error, core::Severity::warning, core::Severity::note})
    out += findings_table(all, severity);
  return out.empty() ? "<p class=\"good\">No findings.</p>\n" : out;
}

std::string section(const SystemReport& system, std::size_t number) {
  const auto title = html_text(system.system.name.empty() ? system.file : system.system.name);
  auto out = fmt::format("<section>\n<h2>{}</h2>\n<p><code>{}</code></p>\n", title,
                         html_text(system.file));
  out += summary(title, system);
  if (system.readable) out += figure(system, number);
  out += findings(system.findings);
  if (system.readable)
    out += channels_table(system) + networks_table(system) + user_attributes_table(system.system);
  return out + "</section>\n";
}

}  // namespace

std::string write_html(const Report& report) {
  const auto totals = report.totals();
  std::string out(kHead);
  out += fmt::format("<title>MLCCA check: {}, {}</title>\n", counted(totals.errors, "error"),
                     counted(totals.warnings, "warning"));
  out += kStyle;
  out += fmt::format(
      "</head>\n<body>\n<h1>MLCCA check</h1>\n<p class=\"counts\"><span class=\"bad\">{}</span>"
      "<span class=\"maybe\">{}</span><span>{}</span></p>\n",
      counted(totals.errors, "error"), counted(totals.warnings, "warning"),
      counted(totals.notes, "note"));
  for (std::size_t i = 0; i < report.systems.size(); ++i) out += section(report.systems[i], i + 1);
  if (!report.part_files.empty() && report.systems.empty())
    out += "<section>\n<h2>Parts</h2>\n" + findings(report.parts) + "</section>\n";
  out += fmt::format("<footer>mlccactl {}</footer>\n</body>\n</html>\n", kVersion);
  return out;
}

}  // namespace mlcca::tools::design
