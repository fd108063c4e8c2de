// SPDX-License-Identifier: BSD-2-Clause
// Decides when mlccad is asked for what.
#pragma once
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <utility>

#include "tools/exporter/answers.hpp"
#include "tools/exporter/metrics.hpp"

namespace mlcca::exporter {

/// What the command line states.
struct Settings {
  std::string socket = "/run/mlcca/control.sock";
  unsigned timeout_s = 5;
  Most most;
};

/// Answers scrapes one after another. Answers of the kind Live are requested in each scrape.
/// Reports make mlccad fork, so they are requested after a scrape and shown in the next one. If
/// they are older than a minute or than the description in force, or if there are none, they are
/// requested in the scrape itself. While mlccad does not answer none are shown.
class Scrapes {
 public:
  using Say = std::function<void(const std::string&)>;
  /// `now_ns` is a monotonic clock.
  Scrapes(Settings settings, Say say, std::function<std::uint64_t()> now_ns)
      : settings_(std::move(settings)), say_(std::move(say)), now_ns_(std::move(now_ns)) {}

  /// Makes the page for a scrape.
  [[nodiscard]] std::string page();

  /// Whether reports should be requested. Call work() then, when no scrape is waiting.
  [[nodiscard]] bool has_work() const { return due_; }
  /// Requests reports for the next page.
  void work();

 private:
  [[nodiscard]] Asking asking() const;
  void take_reports(Asking& from);
  void note(const std::vector<Failure>& failures);
  [[nodiscard]] double age_s() const;

  Settings settings_;
  Say say_;
  std::function<std::uint64_t()> now_ns_;
  Past past_;
  std::set<std::string> failed_;  ///< requests whose failure was reported
  Reports reports_;
  std::uint64_t reports_at_ = 0;                        ///< ns; 0: there are none
  std::pair<std::uint64_t, std::uint64_t> reports_of_;  ///< start time and load of the daemon that
                                                        ///< made them
  bool due_ = false;
};

}  // namespace mlcca::exporter
