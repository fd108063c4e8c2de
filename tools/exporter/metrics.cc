// SPDX-License-Identifier: BSD-2-Clause
#include "tools/exporter/metrics.hpp"

#include <algorithm>

#include "base/ascii.hpp"
#include "control/version.hpp"
#include "tools/exporter/exposition.hpp"

namespace mlcca::exporter {
namespace {

constexpr std::size_t kBytesOfADelivery = 1024;

/// Whether a character can be part of a name or address, so that adjacent digits belong to it.
bool is_of_a_word(char c) {
  return is_alphanumeric(c) || c == '_' || c == '-' || c == ':' || c == '/' ||
         (static_cast<unsigned char>(c) & 0x80U) != 0;
}

/// The end of the decimal number that begins at `from`.
std::size_t end_of_number(std::string_view text, std::size_t from) {
  std::size_t at = from;
  while (at < text.size() && is_digit(text[at])) ++at;
  if (at + 1 < text.size() && text[at] == '.' && is_digit(text[at + 1])) {
    ++at;
    while (at < text.size() && is_digit(text[at])) ++at;
  }
  return at;
}

/// Whether a word continues at `at`, as in "10.0.0.7" or "2a", but not in "2:" or "5 ms".
bool goes_on(std::string_view text, std::size_t at) {
  if (at >= text.size()) return false;
  const char after = at + 1 < text.size() ? text[at + 1] : ' ';
  if (text[at] == '.' || text[at] == ':') return is_of_a_word(after);
  return is_of_a_word(text[at]);
}

/// Whether a word is what a sender chooses that nobody has described: a subject or identifier in
/// hexadecimal form, or an address.
bool is_of_a_sender(std::string_view word) {
  const auto is_hex = [](std::string_view text) {
    return std::ranges::all_of(
        text, [](char c) { return is_digit(c) || std::string_view("abcdefABCDEF.:").contains(c); });
  };
  if (word.starts_with("0x")) return is_hex(word.substr(2));
  return is_hex(word) && (std::ranges::count(word, ':') >= 2 || std::ranges::count(word, '.') == 3);
}

void add_self(const Answers& answers, const LeftOut& left_out, const Past& past, double took_s,
              std::string& page) {
  Family build("mlcca_exporter_build_info", "gauge", "The version of this exporter; always 1.");
  build.add(Labels{{"version", kVersion}}, true);
  build.append_to(page);
  Family took("mlcca_exporter_scrape_duration_seconds", "gauge", "How long mlccad was asked.");
  took.add(took_s);
  took.append_to(page);
  Family scrapes("mlcca_exporter_scrapes_total", "counter", "Scrapes since this exporter started.");
  scrapes.add(past.scrapes);
  scrapes.append_to(page);
  Family failures("mlcca_exporter_scrape_errors_total", "counter",
                  "Requests to mlccad that failed since this exporter started.");
  for (const char* request : {"connect", "status", "networks", "channels", "reservations", "gate",
                              "routes", "cluster", "members"}) {
    const auto known = past.failures.find(request);
    failures.add(Labels{{"request", request}},
                 known == past.failures.end() ? std::uint64_t{0} : known->second);
  }
  failures.append_to(page);
  if (!answers.live.status) return;
  Family age("mlcca_exporter_reports_age_seconds", "gauge",
             "Age of what is not asked in each scrape: networks, resources, links and the room of "
             "gates.");
  age.add(answers.reports_age_s);
  age.append_to(page);
  Family left("mlcca_exporter_left_out", "gauge",
              "How many of a kind have no series because there are more than the limit.");
  for (const auto& [kind, count] : left_out)
    left.add(Labels{{"kind", kind}}, static_cast<std::uint64_t>(count));
  left.append_to(page);
}

}  // namespace

std::string kind_of(std::string_view reason) {
  // What was seen latest differs from time to time, and any station can send it.
  reason = reason.substr(0, reason.find(", the latest"));
  std::string out;
  out.reserve(reason.size());
  for (std::size_t at = 0; at < reason.size();) {
    const bool begins = is_digit(reason[at]) &&
                        (at == 0 || (!is_of_a_word(reason[at - 1]) && reason[at - 1] != '.'));
    const std::size_t end = begins ? end_of_number(reason, at) : at;
    if (begins && !goes_on(reason, end)) {
      out += 'N';
      at = end;
      continue;
    }
    // Takes the complete word, so that its digits do not count as numbers.
    const std::size_t from = at++;
    while (at < reason.size() && (is_of_a_word(reason[at - 1]) || reason[at - 1] == '.') &&
           (is_of_a_word(reason[at]) || reason[at] == '.'))
      ++at;
    std::string_view word = reason.substr(from, at - from);
    std::string_view name = word;
    while (name.ends_with('.') || name.ends_with(':')) name.remove_suffix(1);
    if (!name.empty() && is_of_a_sender(name)) {
      out += 'N';
      word.remove_prefix(name.size());
    }
    out += word;
  }
  return out;
}

std::string page(const Answers& answers, const Most& most, const Past& past, double took_s) {
  std::string page;
  if (answers.live.channels)  // an estimate, so that the page is rarely moved while it grows
    page.reserve(answers.live.channels->channels.size() * kBytesOfADelivery);
  LeftOut left_out{{"deliveries", 0}, {"interfaces", 0}, {"networks", 0}, {"resources", 0},
                   {"links", 0},      {"control", 0},    {"reasons", 0}};
  Family up("mlcca_up", "gauge", "Whether mlccad answered; without an answer nothing is known.");
  up.add(answers.live.status.has_value());
  up.append_to(page);
  const auto& [live, reports, age_s] = answers;
  if (live.status) {
    add_status(*live.status, most, left_out, page);
    add_networks(reports, most, left_out, page);
    if (reports.gates) add_gates(*reports.gates, most, left_out, page);
    // Without a cluster there are no metrics about one.
    if (live.cluster && !live.cluster->system.empty()) {
      add_cluster(*live.cluster, page);
      if (reports.members) add_members(*reports.members, most, left_out, page);
    }
    if (live.channels) add_deliveries(*live.channels, most, left_out, page);
  } else {
    add_health_state(control::HealthState::unknown, page);
  }
  add_self(answers, left_out, past, took_s, page);
  return page;
}

}  // namespace mlcca::exporter
