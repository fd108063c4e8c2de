// SPDX-License-Identifier: BSD-2-Clause
// What is taken of the media that are analysed: buses and meshes.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "core/can/of_system.hpp"
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

/// Verdict, response and what is left of the deadline, as cells.
struct Response {
  std::string verdict;
  std::string time;
  std::string left;
};

Response response_of(const core::BusMessage& m) {
  if (!m.message)
    return {verdict({"?", "not analysed: the description does not say enough", "run-time"}), "",
            ""};
  const auto response = m.granted ? m.granted_response : m.refused_response;
  Response out;
  if (m.granted)
    out.verdict = verdict({"✓", "in time", "fit"});
  else if (m.refused_response)
    out.verdict = verdict({"✕", "late", "unfit"});
  else
    out.verdict =
        verdict({"✕", m.in_vain ? "others would be late" : "refused for another reason", "unfit"});
  if (!response) return out;
  out.time = time_text(*response);
  if (*response == core::can::kNever) return out;
  const Value deadline = m.message->deadline;
  out.left = *response <= deadline ? time_text(deadline - *response) + " to spare"
                                   : time_text(*response - deadline) + " too late";
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

std::string bus_table(const SystemReport& report, std::size_t n) {
  const core::System& system = report.system;
  const core::Network& network = system.networks[n];
  const core::NetworkLoad& load = report.inspection.networks[n];
  Rows rows("Bus " + html_text(network.name),
            {"Message", "Identifier", "In time", "Response, at most", "Deadline", "Left"});
  std::vector<const core::BusMessage*> messages;
  for (const core::BusMessage& m : report.buses.messages)
    if (m.network == n) messages.push_back(&m);
  // As arbitration has them.
  std::ranges::stable_sort(messages, {}, [](const core::BusMessage* m) {
    return m->message ? std::uint64_t{m->message->priority} : ~std::uint64_t{0};
  });
  for (const core::BusMessage* m : messages) {
    if (!rows.wants_more()) continue;
    const auto& publisher = system.publishers[m->publisher];
    const Response response = response_of(*m);
    rows.add({html_text(system.channels[publisher.channel].name) + " <span class=\"quiet\">of " +
                  html_text(publisher.name) + "</span>" + way_in(system, *m),
              "<code>" + identifier_text(system, *m) + "</code>", response.verdict, response.time,
              m->message ? time_text(m->message->deadline) : "", response.left},
             m->granted ? "fit" : "unfit");
  }
  const bool refused = std::ranges::any_of(messages, [](const auto* m) { return !m->granted; });
  const auto above =
      fmt::format("<p class=\"load\">{} of the time of the bus at {} for what is granted{}{}</p>\n",
                  meter(load.time_ppm.value_or(0), kWholeTime), print_bitrate(network.bus.bitrate),
                  network.bus.background == 0
                      ? ""
                      : fmt::format(", {:.2f} % of it taken by others",
                                    static_cast<double>(network.bus.background) / 10'000),
                  refused ? "; what is refused is not counted, and a sender on the bus itself "
                            "takes time of it all the same"
                          : "");
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
  return fmt::format(
      "<div class=\"card\">\n<h3>Medium time of {}</h3>\n<p>What fits takes nothing of it; at most "
      "{} "
      "of each domain may be taken.</p>\n</div>\n",
      html_text(network.name), percent(limit));
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
