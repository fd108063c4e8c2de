// SPDX-License-Identifier: BSD-2-Clause
// The tables of analysed media: the load of buses and meshes.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/can/analysis.hpp"
#include "core/can/of_system.hpp"
#include "core/design/bus_fate.hpp"
#include "core/design/bus_responses.hpp"
#include "core/mesh/roles.hpp"
#include "core/model/text.hpp"
#include "tools/design/check/tables.hpp"
#include "tools/escape.hpp"
#include "tools/values.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::uint64_t kWholeTime = 1'000'000;  // ppm

std::string time_text(Value ns) {
  return ns == core::can::kNever ? "no bound" : core::format_value(Attribute::latency, ns);
}

/// The cells of a message: verdict, response time, deadline and remaining time.
struct Response {
  std::string verdict;
  std::string time;
  std::string deadline;
  std::string left;
};

Said said_of_held(const core::BusMessage& m, core::BusFate fate) {
  if (fate == core::BusFate::late || fate == core::BusFate::not_bounded)
    return {"✕", "late while what is refused here is sent", "unfit"};
  if (fate == core::BusFate::queue_too_short)
    return {"✕", "may be lost in its queue while what is refused here is sent", "unfit"};
  if (m.outcome == Outcome::run_time) return {"◌", "in time, if it is granted", "run-time"};
  return {"✓", "in time", "fit"};
}

/// The verdict on a message that is refused or decided at run time.
Said said_of_other(core::BusFate fate) {
  switch (fate) {
    case core::BusFate::run_time:
      return {"◌", "decided at run time, in place of others", "run-time"};
    case core::BusFate::late:
      return {"✕", "late", "unfit"};
    case core::BusFate::not_bounded:
      return {"✕", "not bounded", "unfit"};
    case core::BusFate::queue_too_short:
      return {"✕", "its queue is too short", "unfit"};
    case core::BusFate::refused_for_others:
      return {"✕", "others would be late", "unfit"};
    default:
      return {"✕", "refused for another reason", "unfit"};
  }
}

/// `sent` is the message with its response beside those that count.
Response response_of(const core::BusMessage& m, const core::SentMessage& sent,
                     const core::can::Assumptions& bus) {
  if (!m.sent)
    return {verdict({"?", "not analysed: the description does not say enough", "run-time"}), "", "",
            ""};
  const core::BusRow row = core::row_of(core::decision_of(m), bus, *m.sent, sent.response);
  Response out;
  out.verdict = verdict(m.held ? said_of_held(m, row.fate) : said_of_other(row.fate));
  const Value deadline = m.sent->deadline;
  out.deadline = time_text(deadline);
  if (!row.response) return out;
  if (*row.response == core::can::kNever) {
    out.time = time_text(*row.response);
    return out;
  }
  const auto words = core::format_bound(Attribute::latency, *row.response, deadline);
  out.time = words.bound;
  if (sent.by_admission) out.time += " <span class=\"quiet\">by admission</span>";
  out.deadline = words.limit;
  out.left = *row.response <= deadline ? time_text(deadline - *row.response) + " to spare"
                                       : time_text(*row.response - deadline) + " too late";
  return out;
}

std::string identifier_text(const core::System& system, const core::BusMessage& m) {
  const auto& network = system.networks[m.network];
  const auto& publisher = system.publishers[m.publisher];
  const auto* binding = network.binding_of(publisher.channel);
  if (binding == nullptr) return "none";
  if (binding->waits_for_tag()) return "tag not known";
  const auto identifier =
      core::can::identifier_of(publisher, network, *binding, m.message && m.message->frames > 1);
  if (!identifier) return "not known";
  return identifier->extended ? fmt::format("0x{:08x}", identifier->id)
                              : fmt::format("0x{:03x}", identifier->id);
}

std::string way_in(const core::System& system, const core::BusMessage& m) {
  if (m.from == core::Flow::kOwn) return {};
  for (std::size_t g = 0; g < system.gateways.size(); ++g)
    if (system.resource_of({core::Place::Kind::gateway, g}) == m.from)
      return " <span class=\"quiet\">over " + html_text(system.gateways[g].name) + "</span>";
  return {};
}

/// Says which messages the load of a bus contains.
std::string counted_words(const std::vector<const core::BusMessage*>& messages) {
  bool refused = false;
  bool unknown = false;
  for (const core::BusMessage* m : messages) {
    refused = refused || (m->present && !m->held && m->sent);
    unknown = unknown || (m->present && !m->sent);
  }
  std::string words = "what is granted";
  if (refused) words += " and what its own nodes send though it is refused";
  if (unknown) words += "; how much others of them send is not known";
  return words;
}

std::string bus_table(const SystemReport& report, std::size_t n) {
  const core::System& system = report.system;
  const core::Network& network = system.networks[n];
  Rows rows("Bus " + html_text(network.name),
            {"Message", "Identifier", "In time", "Response, at most", "Deadline", "Left"});
  std::map<const core::BusMessage*, core::SentMessage> responses;
  for (const core::SentMessage& sent : core::sent_beside(report.buses, n))
    responses[sent.message] = sent;
  std::vector<const core::BusMessage*> messages;
  for (const core::BusMessage& m : report.buses.messages)
    if (m.network == n) messages.push_back(&m);
  // In order of arbitration.
  std::ranges::stable_sort(messages, {}, [](const core::BusMessage* m) {
    return m->message ? std::uint64_t{m->message->priority} : ~std::uint64_t{0};
  });
  for (const core::BusMessage* m : messages) {
    if (!rows.wants_more()) continue;
    const auto& publisher = system.publishers[m->publisher];
    const Response response = response_of(*m, responses[m], *report.buses.assumptions[n]);
    rows.add({html_text(system.channels[publisher.channel].name) + " <span class=\"quiet\">of " +
                  html_text(publisher.name) + "</span>" + way_in(system, *m),
              "<code>" + identifier_text(system, *m) + "</code>", response.verdict, response.time,
              response.deadline, response.left},
             m->held ? "fit" : "unfit");
  }
  const core::BusLoad load = core::load_on(report.buses, n).value_or(core::BusLoad{});
  const auto percent = [](std::uint64_t ppm) { return static_cast<double>(ppm) / 10'000; };
  auto above = fmt::format("<p class=\"load\">{} of the time of the bus at {} for {}",
                           meter(load.present, kWholeTime), print_bitrate(network.bus.bitrate),
                           counted_words(messages));
  if (load.at_most != load.present)
    above += fmt::format("; up to {:.2f} % with what may be granted in the place of others",
                         percent(load.at_most));
  if (network.bus.background != 0)
    above += fmt::format(", {:.2f} % of it taken by others", percent(network.bus.background));
  above += "</p>\n";
  auto html = rows.html(above);
  if (!html.empty()) return html;
  return fmt::format("<div class=\"card\">\n<h3>Bus {}</h3>\n{}<p>No message is on it.</p></div>\n",
                     html_text(network.name), above);
}

std::string mesh_table(const SystemReport& report, std::size_t n) {
  const core::Network& network = report.system.networks[n];
  auto domains = report.inspection.networks[n].domains;
  std::ranges::stable_sort(domains, std::ranges::greater{}, &core::DomainLoad::time_ppm);
  Rows rows("Medium time of " + html_text(network.name), {"Domain", "Taken", "Limit", "Left"});
  const std::uint64_t limit = network.mesh->limit;
  const auto percent = [](std::uint64_t ppm) {
    return fmt::format("{:.2f} %", static_cast<double>(ppm) / 10'000);
  };
  for (const core::DomainLoad& domain : domains)
    if (rows.wants_more())
      rows.add({html_text(domain.name), meter(domain.time_ppm, limit), percent(limit),
                percent(limit - std::min(limit, domain.time_ppm))});
  auto html = rows.html();
  if (!html.empty()) return html;
  const char* const taken = core::mesh::is_measured(*network.mesh)
                                ? "How much is taken of it is known when its links are measured, "
                                  "at run time"
                                : "What fits takes nothing of it";
  return fmt::format(
      "<div class=\"card\">\n<h3>Medium time of {}</h3>\n<p>{}; at most {} of each domain may be "
      "taken.</p>\n</div>\n",
      html_text(network.name), taken, percent(limit));
}

}  // namespace

std::string buses_tables(const SystemReport& report) {
  std::string out;
  for (std::size_t n = 0; n < report.buses.assumptions.size(); ++n)
    if (report.buses.assumptions[n]) out += bus_table(report, n);
  return out;
}

std::string meshes_tables(const SystemReport& report) {
  std::string out;
  for (std::size_t n = 0; n < report.inspection.networks.size(); ++n)
    if (report.system.networks[n].mesh && report.inspection.networks[n].time_ppm)
      out += mesh_table(report, n);
  return out;
}

}  // namespace mlcca::tools::design
