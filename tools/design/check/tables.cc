// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/check/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "core/model/text.hpp"
#include "tools/escape.hpp"

namespace mlcca::tools::design {
namespace {

/// A table that stops at kMaxRows. Cells are HTML.
class Rows {
 public:
  Rows(const char* title, std::initializer_list<const char*> columns) : title_(title) {
    for (const auto* column : columns) head_ += fmt::format("<th scope=\"col\">{}</th>", column);
    columns_ = columns.size();
  }

  /// False where the row would not be shown: it need not be made.
  bool wants_more() {
    ++all_;
    return all_ <= kMaxRows;
  }
  void add(std::initializer_list<std::string> cells, const char* kind = "") {
    body_ += fmt::format("<tr class=\"{}\">", kind);
    for (const auto& cell : cells) body_ += "<td>" + cell + "</td>";
    body_ += "</tr>\n";
  }

  [[nodiscard]] std::string html() const {
    if (all_ == 0) return {};
    auto out = fmt::format("<h3>{} ({})</h3>\n<table>\n<thead><tr>{}</tr></thead>\n<tbody>\n{}",
                           title_, all_, head_, body_);
    if (all_ > kMaxRows)
      out += fmt::format("<tr><td colspan=\"{}\" class=\"more\">{} more are not shown</td></tr>\n",
                         columns_, all_ - kMaxRows);
    return out + "</tbody>\n</table>\n";
  }

 private:
  const char* title_;
  std::string head_;
  std::string body_;
  std::size_t columns_ = 0;
  std::size_t all_ = 0;
};

const char* title_of(core::Severity severity) {
  switch (severity) {
    case core::Severity::error:
      return "Errors";
    case core::Severity::warning:
      return "Warnings";
    case core::Severity::note:
      break;
  }
  return "Notes";
}

std::string finding_text(const ReportedFinding& f) {
  auto out = f.element.empty() ? "" : "<code>&lt;" + html_text(f.element) + "&gt;</code> ";
  out += html_text(f.text);
  if (!f.hint.empty()) out += "<p class=\"hint\">" + html_text(f.hint) + "</p>";
  return out;
}

/// Word and class of an outcome; the word carries it without colour.
struct Said {
  const char* word;
  const char* kind;
};

Said said(Outcome outcome) {
  switch (outcome) {
    case Outcome::fit:
      return {"✓ fit", "fit"};
    case Outcome::run_time:
      return {"◌ decided at run time", "run-time"};
    case Outcome::unfit:
      break;
  }
  return {"✗ does not fit", "unfit"};
}

/// "Latency 5 ms, Omission 0 (best case)"
std::string provision_text(const core::System& system, const AttributeSet& set,
                           const core::UserValues& user) {
  std::string out;
  const auto add = [&](std::string_view name, std::string_view value, bool dynamic) {
    out += fmt::format("{}{} {}{}", out.empty() ? "" : ", ", name, value,
                       dynamic ? " (best case)" : "");
  };
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const auto a = attribute_at(i);
    if (set.has(a)) add(info(a).name, core::format_value(a, set[a]), set.is_dynamic(a));
  }
  for (const auto& value : user) {
    const auto& attribute = system.user_attributes[value.attribute];
    add(attribute.name, core::format_user_value(attribute, value.value), value.dynamic);
  }
  return out.empty() ? "nothing is stated" : html_text(out);
}

std::string bar(double percent) {
  return fmt::format(R"(<span class="bar"><span style="width:{:.1f}%"></span></span> )",
                     std::min(percent, 100.0));
}

/// Where both a bandwidth is stated and the time of the medium is computed, both.
std::string load_cell(const core::Network& network, const core::NetworkLoad& load) {
  std::string out;
  if (network.provision.has(Attribute::bandwidth)) {
    const Value capacity = network.provision[Attribute::bandwidth];
    const double percent = capacity == 0
                               ? 0.0
                               : 100.0 * std::min(1.0, static_cast<double>(load.reserved) /
                                                           static_cast<double>(capacity));
    out = fmt::format("{}{} of {} ({:.1f} %)", bar(percent),
                      core::format_value(Attribute::bandwidth, load.reserved),
                      core::format_value(Attribute::bandwidth, capacity), percent);
  }
  if (load.time_ppm) {
    const double percent = static_cast<double>(*load.time_ppm) / 10'000;
    out += fmt::format("{}{}{:.2f} % of the time of the {}", out.empty() ? "" : "<br>",
                       bar(percent), percent, network.mesh ? "medium" : "bus");
  }
  return out.empty() ? "no capacity is stated" : out;
}

const char* words_of(Composition composition) {
  switch (composition) {
    case Composition::sum:
      return "sum";
    case Composition::slowest:
      return "maximum";
    case Composition::smallest:
      return "minimum";
    default:
      return "survival";
  }
}

std::string set_words(const core::EventChannel& channel, std::size_t set) {
  if (channel.lower.empty()) return {};
  if (set == 0) return fmt::format("priority {}", channel.priority);
  return fmt::format("priority {} (not the preferred one)", channel.lower[set - 1].priority);
}

void add_channels(Rows& rows, const SystemReport& system, Outcome outcome) {
  for (std::size_t c = 0; c < system.inspection.channels.size(); ++c) {
    const auto& result = system.inspection.channels[c];
    if (result.outcome != outcome || !rows.wants_more()) continue;
    const auto& channel = system.system.channels[c];
    const auto [word, kind] = said(outcome);
    const auto set = set_words(channel, result.set);
    rows.add({html_text(channel.name), "<code>" + core::format_subject(channel.subject) + "</code>",
              std::to_string(result.deliveries), word, set, html_text(channel.description)},
             kind);
  }
}

}  // namespace

std::string findings_table(const std::vector<ReportedFinding>& findings, core::Severity severity) {
  Rows rows(title_of(severity), {"Id", "Where", "What"});
  for (const auto& f : findings) {
    const auto& info = core::info(f.id);
    if (info.severity != severity || !rows.wants_more()) continue;
    const auto where = f.line > 0 ? fmt::format("{}:{}", f.file, f.line) : f.file;
    rows.add({fmt::format("<abbr title=\"{}: {}\">{}</abbr>", html_text(info.title),
                          html_text(info.advice), core::code_of(f.id)),
              "<code>" + html_text(where) + "</code>", finding_text(f)});
  }
  return rows.html();
}

std::string channels_table(const SystemReport& system) {
  Rows rows("Channels",
            {"Channel", "Subject", "Deliveries", "Outcome", "Attribute set", "Description"});
  for (const auto outcome : {Outcome::unfit, Outcome::run_time, Outcome::fit})
    add_channels(rows, system, outcome);
  return rows.html();
}

std::string networks_table(const SystemReport& report) {
  Rows rows("Networks and gateways", {"Name", "Kind", "Provides", "Reserved"});
  const auto& system = report.system;
  for (std::size_t n = 0; n < system.networks.size(); ++n) {
    if (!rows.wants_more()) continue;
    const auto& network = system.networks[n];
    const auto load = n < report.inspection.networks.size()
                          ? load_cell(network, report.inspection.networks[n])
                          : "";
    rows.add({html_text(network.name), std::string(core::to_text(network.kind)),
              provision_text(system, network.provision, network.user), load});
  }
  for (const auto& gateway : system.gateways)
    if (rows.wants_more())
      rows.add({html_text(gateway.name), "gateway",
                provision_text(system, gateway.provision, gateway.user), ""});
  return rows.html();
}

std::string user_attributes_table(const core::System& system) {
  Rows rows("User-defined attributes", {"Name", "Unit", "Better", "A route gives the"});
  for (const auto& a : system.user_attributes) {
    if (!rows.wants_more()) continue;
    const auto unit = a.unit.empty() ? "number" : a.unit;
    rows.add({html_text(a.name),
              html_text(a.magnitude == 0 ? unit : fmt::format("1e{} {}", a.magnitude, unit)),
              a.better == Better::smaller ? "smaller" : "larger", words_of(a.composition)});
  }
  return rows.html();
}

}  // namespace mlcca::tools::design
