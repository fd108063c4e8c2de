// SPDX-License-Identifier: BSD-2-Clause
#include "tools/exporter/scrapes.hpp"

#include <fmt/format.h>

#include <chrono>

namespace mlcca::exporter {
namespace {

constexpr double kOldest = 60;  // s
constexpr double kNs = 1e-9;    // s

std::pair<std::uint64_t, std::uint64_t> life_of(const control::Status& status) {
  return {status.started_unix_s, status.loaded_unix_s};
}

}  // namespace

Asking Scrapes::asking() const {
  return {settings_.socket, std::chrono::seconds(settings_.timeout_s)};
}

double Scrapes::age_s() const { return static_cast<double>(now_ns_() - reports_at_) * kNs; }

void Scrapes::take_reports(Asking& from) {
  reports_ = from.reports();
  reports_at_ = now_ns_();
  due_ = false;
}

/// Reports failures that are new. Every scrape repeats the requests, so a failure that lasts was
/// reported already.
void Scrapes::note(const std::vector<Failure>& failures) {
  std::set<std::string> failed;
  for (const auto& [request, why] : failures) {
    ++past_.failures[request];
    failed.insert(fmt::format("{}: {}", request, why));
  }
  for (const auto& why : failed)
    if (!failed_.contains(why)) say_(why);
  if (failed.empty() && !failed_.empty()) say_("mlccad answers again");
  failed_ = std::move(failed);
}

std::string Scrapes::page() {
  const std::uint64_t began = now_ns_();
  ++past_.scrapes;
  auto from = asking();
  Answers answers;
  answers.live = from.live();
  if (!answers.live.status) {
    reports_at_ = 0;
    due_ = false;
  } else {
    const bool usable =
        reports_at_ != 0 && age_s() < kOldest && reports_of_ == life_of(*answers.live.status);
    due_ = usable;
    if (!usable) take_reports(from);
    reports_of_ = life_of(*answers.live.status);
    answers.reports = reports_;
    answers.reports_age_s = age_s();
  }
  note(from.failures());
  return exporter::page(answers, settings_.most, past_,
                        static_cast<double>(now_ns_() - began) * kNs);
}

void Scrapes::work() {
  auto from = asking();
  take_reports(from);
  note(from.failures());
  // Missing reports are requested again in the next scrape.
  if (!from.failures().empty()) reports_at_ = 0;
}

}  // namespace mlcca::exporter
