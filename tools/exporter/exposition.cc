// SPDX-License-Identifier: BSD-2-Clause
#include "tools/exporter/exposition.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

namespace mlcca::exporter {

void Labels::add(std::string_view name, std::string_view value) {
  if (!text_.empty()) text_ += ',';
  text_ += name;
  text_ += "=\"";
  for (const char c : value) {
    if (c == '\\' || c == '"') text_ += '\\';
    if (c == '\n')
      text_ += "\\n";
    else
      text_ += c;
  }
  text_ += '"';
}

Family::Family(std::string_view name, std::string_view type, std::string_view help)
    : name_(name), type_(type), help_(help) {}

void Family::begin(const Labels& labels) {
  samples_ += name_;
  if (!labels.text().empty()) {
    samples_ += '{';
    samples_ += labels.text();
    samples_ += '}';
  }
  samples_ += ' ';
}

void Family::add(const Labels& labels, double value) {
  begin(labels);
  if (std::isinf(value))
    samples_ += value > 0 ? "+Inf" : "-Inf";
  else if (std::isnan(value))
    samples_ += "NaN";
  else
    fmt::format_to(std::back_inserter(samples_), "{}", value);
  samples_ += '\n';
}

void Family::add(const Labels& labels, std::uint64_t value) {
  begin(labels);
  fmt::format_to(std::back_inserter(samples_), "{}\n", value);
}

std::string Family::text() const {
  std::string text;
  append_to(text);
  return text;
}

void Family::append_to(std::string& page) const {
  if (samples_.empty()) return;
  fmt::format_to(std::back_inserter(page), "# HELP {} {}\n# TYPE {} {}\n", name_, help_, name_,
                 type_);
  page += samples_;
}

}  // namespace mlcca::exporter
