// SPDX-License-Identifier: BSD-2-Clause
// The page is self-contained. Its tables are complete without the script, which adds the drawing.
// Text of the description is escaped.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "base/many.hpp"
#include "control/version.hpp"
#include "description/kinds.hpp"
#include "tools/design/check/map.hpp"
#include "tools/design/check/page.hpp"
#include "tools/design/check/tables.hpp"
#include "tools/design/check/write.hpp"
#include "tools/escape.hpp"

namespace mlcca::tools::design {
namespace {

using Json = nlohmann::ordered_json;

// The Content-Security-Policy protects even if a text were not escaped: nothing is loaded, and no
// other script runs.
constexpr std::string_view kHead = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; )"
                                   R"(style-src 'unsafe-inline'; script-src '{}'">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>MLCCA check: {}, {}</title>
<style>
)";

constexpr std::string_view kLegend =
    "<p class=\"legend\"><span class=\"outcome fit\">✓ fits</span> · "
    "<span class=\"outcome run-time\">◌ decided at run time</span> · "
    "<span class=\"outcome unfit\">✕ does not fit</span>: deliveries from one place to the next. "
    "A channel of the table below shows its way.</p>\n";

std::string figure(std::string_view name, std::size_t n, std::string_view kind) {
  return fmt::format("<div class=\"{}\"><dt>{}</dt><dd>{}</dd></div>", n == 0 ? "" : kind, name, n);
}

/// The summary of the report: class, symbol and sentence.
struct Headline {
  const char* kind;
  const char* mark;
  std::string text;
};

Headline headline(const Report& report, const Totals& totals) {
  if (totals.errors != 0)
    return {"bad", "✕",
            many(totals.errors, "error") +
                (report.readable() ? ": not everything can work" : ": not everything can be read")};
  if (totals.warnings != 0) return {"warn", "!", "No errors, " + many(totals.warnings, "warning")};
  std::size_t open = 0;
  for (const auto& system : report.systems) open += counts_of(system).run_time;
  if (open != 0)
    return {"good", "✓", "No errors; " + many(open, "channel") + " decided at run time"};
  return {"good", "✓", "No errors"};
}

std::string top(const Report& report) {
  const auto totals = report.totals();
  const auto [kind, mark, text] = headline(report, totals);
  return fmt::format(
      "<header class=\"health {}\">\n<h1>MLCCA check</h1>\n<p class=\"headline\">"
      "<span class=\"mark\" aria-hidden=\"true\">{}</span>{}</p>\n<dl class=\"figures\">{}{}{}"
      "</dl>\n</header>\n",
      kind, mark, text, figure("errors", totals.errors, "bad"),
      figure("warnings", totals.warnings, "warn"), figure("notes", totals.notes, ""));
}

std::string title_of(const SystemReport& system, const FileNames& names) {
  return html_text(system.system.name.empty() ? names.of(system.file) : system.system.name);
}

std::string summary(const SystemReport& system) {
  if (!system.readable)
    return "<p class=\"trouble\">It cannot be read: repair the errors first.</p>\n";
  if (!system.inspected)
    return "<p class=\"trouble\">The deliveries are checked when the names and rules are "
           "right.</p>\n";
  const auto counts = counts_of(system);
  const auto part = [](std::size_t n, const char* words, std::string_view kind) {
    return fmt::format("<span class=\"{}\"><b>{}</b> {}</span>", n == 0 ? "quiet" : kind, n, words);
  };
  return fmt::format(
      "{}<p class=\"counts\"><span>{}:</span> {} {} {} {}</p>\n",
      system.usable ? ""
                    : "<p class=\"trouble\">The description is not usable for the errors below. "
                      "Without them:</p>\n",
      many(system.inspection.channels.size(), "channel"),
      part(counts.fit, system.usable ? "fit" : "would fit", said(Outcome::fit).kind),
      part(counts.run_time, "decided at run time", said(Outcome::run_time).kind),
      part(counts.unfit, "do not fit", said(Outcome::unfit).kind),
      counts.unused == 0 ? "" : part(counts.unused, "without use", "unused"));
}

std::string section(const SystemReport& system, std::size_t number, const FileNames& names,
                    Json& maps) {
  const auto prefix = fmt::format("s{}-", number);
  auto out = fmt::format(
      "<section class=\"system\" aria-labelledby=\"{0}title {0}file\">\n<h2 "
      "id=\"{0}title\">{1}</h2>\n"
      "<p class=\"quiet\" id=\"{0}file\"><code>{2}</code></p>\n{3}",
      prefix, title_of(system, names), path_text(names.of(system.file)), summary(system));
  const auto found = findings_tables(description::shortened(system.findings), names);
  auto map = map_of(system);
  if (!map.json["places"].empty()) {
    out += fmt::format(
        "<div class=\"card\" id=\"{0}map\">\n<h3>Networks</h3>\n<div class=\"chosen\"></div>\n"
        "<div class=\"map\" data-prefix=\"{0}\"><p class=\"quiet\">The drawing is made by a "
        "script. "
        "The tables below say the same.</p></div>\n{1}</div>\n",
        prefix, kLegend);
    maps.push_back(std::move(map.json));
  }
  out += found.empty() ? "<p class=\"none\">No findings.</p>\n" : found;
  if (system.readable)
    out += (system.inspected ? deliveries_table(system, map.way_of, prefix) : "") +
           buses_tables(system) + meshes_tables(system) + places_table(system, prefix) +
           user_attributes_table(system.system);
  return out + "</section>\n";
}

std::string contents(const Report& report, const FileNames& names) {
  if (report.systems.size() < 2) return {};
  std::string out = "<nav class=\"card\" aria-label=\"Systems\">\n<ul>";
  for (std::size_t i = 0; i < report.systems.size(); ++i) {
    const auto& system = report.systems[i];
    const auto errors = std::ranges::count_if(system.findings, [](const ReportedFinding& f) {
      return core::info(f.id).severity == core::Severity::error;
    });
    out += fmt::format(
        R"(<li><a href="#s{}-title">{}</a> <span class="quiet">{}</span>{}</li>)", i + 1,
        title_of(system, names), path_text(names.of(system.file)),
        errors == 0 ? ""
                    : " " + verdict({"✕", many(static_cast<std::size_t>(errors), "error").c_str(),
                                     "unfit"}));
  }
  return out + "</ul>\n</nav>\n";
}

}  // namespace

std::string write_html(const Report& report) {
  const auto totals = report.totals();
  std::error_code gone;
  const FileNames names(report.files(), std::filesystem::current_path(gone).native());
  auto out = fmt::format(kHead, page_script_hash(), many(totals.errors, "error"),
                         many(totals.warnings, "warning"));
  out += page_style();
  out += "</style>\n</head>\n<body>\n<main>\n" + top(report) + contents(report, names);
  Json maps = Json::array();
  for (std::size_t i = 0; i < report.systems.size(); ++i)
    out += section(report.systems[i], i + 1, names, maps);
  if (!report.part_files.empty() && report.systems.empty()) {
    const auto found = findings_tables(description::shortened(report.parts), names);
    out += "<section class=\"system\">\n<h2>Parts</h2>\n" +
           (found.empty() ? "<p class=\"none\">No findings.</p>\n" : found) + "</section>\n";
  }
  out += fmt::format("<footer class=\"quiet\">mlccactl {}</footer>\n</main>\n", kVersion);
  out += R"(<script type="application/json" id="maps">)" +
         json_in_markup(maps.dump(-1, ' ', false, Json::error_handler_t::replace)) + "</script>\n";
  out += R"(<script type="module">)";
  out += page_script();
  return out + "</script>\n</body>\n</html>\n";
}

}  // namespace mlcca::tools::design
