// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/check/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "core/model/text.hpp"
#include "tools/escape.hpp"

namespace mlcca::tools::design {
namespace {

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
  if (!f.hint.empty()) out += "<p class=\"quiet\">" + html_text(f.hint) + "</p>";
  return out;
}

std::string findings_table(const std::vector<ReportedFinding>& findings, core::Severity severity,
                           const FileNames& names) {
  Rows rows(title_of(severity), {"Id", "Where", "What"});
  for (const auto& f : findings) {
    const auto& info = core::info(f.id);
    if (info.severity != severity || !rows.wants_more()) continue;
    const auto file = names.of(f.file);
    const auto where = f.line > 0 ? fmt::format("{}:{}", file, f.line) : file;
    rows.add({fmt::format(R"(<span class="id">{}</span> <span class="quiet id">{}</span>)",
                          core::code_of(f.id), info.name),
              "<code>" + path_text(where) + "</code>", finding_text(f)});
  }
  return rows.html();
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

/// The reserved payload of a network whose capacity is stated; otherwise empty.
std::string reserved_cell(const core::Network& network, const core::NetworkLoad& load) {
  if (!network.provision.has(Attribute::bandwidth)) return {};
  const Value capacity = network.provision[Attribute::bandwidth];
  const double part =
      capacity == 0
          ? 0.0
          : std::min(1.0, static_cast<double>(load.reserved) / static_cast<double>(capacity));
  return fmt::format("{}: {} of {}", meter(static_cast<std::uint64_t>(part * 1e6), 1'000'000),
                     core::format_value(Attribute::bandwidth, load.reserved),
                     core::format_value(Attribute::bandwidth, capacity));
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

std::string set_words(const core::EventChannel& channel, std::size_t set, bool open) {
  if (channel.lower.empty()) return {};
  if (open) return "decided at run time";
  if (set == 0) return fmt::format("priority {}", channel.priority);
  return fmt::format("priority {} (not the preferred one)", channel.lower[set - 1].priority);
}

/// Makes the rows of the channels of one system.
class Deliveries {
 public:
  Deliveries(const SystemReport& report, const std::vector<std::size_t>& ways,
             const std::string& prefix)
      : r_(report),
        s_(report.system),
        ways_(ways),
        prefix_(prefix),
        has_sets_(std::ranges::any_of(s_.channels, [](const auto& c) { return !c.lower.empty(); })),
        has_reactions_(
            std::ranges::any_of(r_.deliveries, [](const auto& d) { return !d.reaction.empty(); })),
        rows_("Channels, by delivery", columns()) {}

  std::string html() && {
    for (const auto outcome : {Outcome::unfit, Outcome::run_time, Outcome::fit}) {
      std::size_t next = 0;
      for (std::size_t c = 0; c < s_.channels.size(); ++c) add_channel(c, next, outcome);
    }
    return rows_.html();
  }

 private:
  [[nodiscard]] std::vector<const char*> columns() const {
    std::vector<const char*> out{"Channel", "Outcome", "From and to", "Way", "Smallest margin"};
    if (has_reactions_) out.push_back("Reaction to silence");
    if (has_sets_) out.push_back("Attribute set");
    return out;
  }

  /// `next` is the index of the first delivery of the channel, and afterwards of the next channel.
  void add_channel(std::size_t c, std::size_t& next, Outcome outcome) {
    const auto& result = r_.inspection.channels[c];
    const std::size_t first = next;
    bool any_unfit = false;
    for (; next < r_.deliveries.size() && r_.deliveries[next].channel == c; ++next)
      any_unfit = any_unfit || r_.deliveries[next].outcome == Outcome::unfit;
    if (first == next) {
      if (result.outcome == outcome && rows_.wants_more())
        add_unused(c, outcome == Outcome::fit ? Said{"–", "without use", "unused"} : said(outcome));
      return;
    }
    // The channel does not fit although each delivery does, such as when a gateway has no room.
    const bool as_a_whole = result.outcome == Outcome::unfit && !any_unfit;
    for (std::size_t d = first; d < next; ++d) {
      const auto own = as_a_whole ? Outcome::unfit : r_.deliveries[d].outcome;
      if (own == outcome && rows_.wants_more()) add_delivery(d, own);
    }
  }

  void add_delivery(std::size_t number, Outcome outcome) {
    const ReportedDelivery& d = r_.deliveries[number];
    const auto ends = fmt::format("{} <span class=\"quiet\">to</span> {}", html_text(d.publisher),
                                  html_text(d.subscribers));
    auto row = cells(d.channel, said(outcome), ends, way(d), html_text(d.margin));
    row[0] = fmt::format(R"(<a href="#{}map" data-way="{}">{}</a>{})", prefix_, ways_[number],
                         html_text(s_.channels[d.channel].name), about(d.channel));
    std::size_t column = 5;
    if (has_reactions_ && !d.reaction.empty())
      row[column] =
          fmt::format("{}{} <span class=\"quiet\">= {}</span>", html_text(d.reaction),
                      outcome == Outcome::run_time ? " at best" : "", html_text(d.reaction_terms));
    column += has_reactions_ ? 1 : 0;
    if (has_sets_)
      row[column] =
          set_words(s_.channels[d.channel], d.set, r_.inspection.channels[d.channel].open_set);
    rows_.add(row, said(outcome).kind);
  }

  void add_unused(std::size_t channel, const Said& outcome) {
    rows_.add(cells(channel, outcome, "", "", "nobody publishes it, or nobody subscribes it"),
              outcome.kind);
  }

  [[nodiscard]] std::string about(std::size_t channel) const {
    const auto& c = s_.channels[channel];
    auto out = fmt::format("<br><code class=\"quiet\">{}</code>", core::format_subject(c.subject));
    if (!c.description.empty())
      out += fmt::format("<p class=\"quiet\">{}</p>", html_text(c.description));
    return out;
  }

  [[nodiscard]] std::vector<std::string> cells(std::size_t channel, const Said& outcome,
                                               std::string ends, std::string way,
                                               std::string margin) const {
    std::vector<std::string> out{html_text(s_.channels[channel].name) + about(channel),
                                 verdict(outcome), std::move(ends), std::move(way),
                                 std::move(margin)};
    out.resize(5U + (has_reactions_ ? 1U : 0U) + (has_sets_ ? 1U : 0U));
    return out;
  }

  [[nodiscard]] std::string way(const ReportedDelivery& d) const {
    if (d.route.empty())
      return fmt::format("{} <span class=\"quiet\">to</span> {}",
                         html_text(core::name_of(s_, d.from)), html_text(core::name_of(s_, d.to)));
    std::string out;
    for (const core::Place place : d.route) {
      const bool stops = d.refused_at && *d.refused_at == place;
      out += fmt::format("{}{}{}", out.empty() ? "" : " › ", stops ? "✕ " : "",
                         html_text(core::name_of(s_, place)));
    }
    return out;
  }

  const SystemReport& r_;
  const core::System& s_;
  const std::vector<std::size_t>& ways_;
  const std::string& prefix_;
  bool has_sets_;
  bool has_reactions_;
  Rows rows_;
};

std::string interface_words(const core::InterfaceIdentity& identity) {
  for (const auto* text : {&identity.name, &identity.alias, &identity.id_path, &identity.serial})
    if (!text->empty()) return *text;
  return {};
}

/// Appends a text such as "gateway by can0".
void join(std::string& out, const std::string& name, const core::Port& port) {
  const auto interface = interface_words(port.identity);
  out += fmt::format("{}{}{}", out.empty() ? "" : ", ", html_text(name),
                     interface.empty() ? "" : " by " + html_text(interface));
}

}  // namespace

FileNames::FileNames(const std::vector<std::string>& files, std::string folder)
    : folder_(std::move(folder)) {
  if (!folder_.ends_with('/')) folder_ += '/';
  bool first = true;
  for (const std::string& file : files) {
    if (!file.starts_with('/') || file.starts_with(folder_)) continue;
    const auto end = first ? file.end() : std::ranges::mismatch(common_, file).in2;
    first = false;
    common_.assign(file.begin(), end);
    common_.resize(common_.rfind('/') + 1);
  }
}

std::string FileNames::of(const std::string& file) const {
  if (file.size() > folder_.size() && file.starts_with(folder_)) return file.substr(folder_.size());
  if (file.size() > common_.size() && file.starts_with(common_)) return file.substr(common_.size());
  return file;
}

std::string findings_tables(const std::vector<ReportedFinding>& findings, const FileNames& names) {
  std::string out;
  for (const auto severity : {core::Severity::error, core::Severity::warning, core::Severity::note})
    out += findings_table(findings, severity, names);
  return out;
}

std::string deliveries_table(const SystemReport& report, const std::vector<std::size_t>& ways,
                             const std::string& prefix) {
  return Deliveries(report, ways, prefix).html();
}

std::string places_table(const SystemReport& report, const std::string& prefix) {
  const auto& system = report.system;
  const bool limited = std::ranges::any_of(system.networks, [](const core::Network& n) {
    return n.provision.has(Attribute::bandwidth);
  });
  std::vector<const char*> columns{"Name", "Kind", "Joined to", "Provides"};
  if (limited) columns.push_back("Reserved");
  Rows rows("Networks and gateways", columns);
  const auto add = [&](core::Place place, std::string kind, std::string joined,
                       const core::UserValues& user, std::string reserved) {
    std::vector<std::string> cells{
        html_text(core::name_of(system, place)), std::move(kind), std::move(joined),
        provision_text(system, system.provision_of(place), user), std::move(reserved)};
    cells.resize(columns.size());
    rows.add(cells, "", fmt::format("{}p{}", prefix, system.resource_of(place)));
  };
  for (std::size_t n = 0; n < system.networks.size(); ++n) {
    if (!rows.wants_more()) continue;
    const auto& network = system.networks[n];
    std::string joined;
    for (const auto& gateway : system.gateways)
      if (const auto* port = gateway.port_on(n)) join(joined, gateway.name, *port);
    add({core::Place::Kind::network, n}, std::string(core::to_text(network.kind)), joined,
        network.user,
        n < report.inspection.networks.size()
            ? reserved_cell(network, report.inspection.networks[n])
            : "");
  }
  for (std::size_t g = 0; g < system.gateways.size(); ++g) {
    if (!rows.wants_more()) continue;
    const auto& gateway = system.gateways[g];
    std::string joined;
    for (const auto& port : gateway.ports) join(joined, system.networks[port.network].name, port);
    add({core::Place::Kind::gateway, g}, "gateway", joined, gateway.user, "");
  }
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
