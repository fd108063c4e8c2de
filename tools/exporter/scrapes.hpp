// SPDX-License-Identifier: BSD-2-Clause
// When mlccad is asked for what.
#pragma once
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <utility>

#include "tools/exporter/answers.hpp"
#include "tools/exporter/metrics.hpp"

namespace mlcca::exporter {

struct Settings {
  std::string socket = "/run/mlcca/control.sock";
  unsigned timeout_s = 5;
  Most most;
};

/// Answers scrapes, one after the other. What mlccad makes at once is asked in each. For reports it
/// forks, so they are asked after a scrape and shown in the next one. None is shown that is older
/// than a minute, or than the description in force, or while mlccad does not answer.
class Scrapes {
 public:
  using Say = std::function<void(const std::string&)>;
  /// `now_ns`: monotonic.
  Scrapes(Settings settings, Say say, std::function<std::uint64_t()> now_ns)
      : settings_(std::move(settings)), say_(std::move(say)), now_ns_(std::move(now_ns)) {}

  [[nodiscard]] std::string page();

  /// Whether reports are to be asked, when nobody waits for a page.
  [[nodiscard]] bool has_work() const { return due_; }
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
  std::set<std::string> failed_;  ///< that was said
  Reports reports_;
  std::uint64_t reports_at_ = 0;                        ///< ns, 0: there are none
  std::pair<std::uint64_t, std::uint64_t> reports_of_;  ///< start and load of that daemon
  bool due_ = false;
};

}  // namespace mlcca::exporter
