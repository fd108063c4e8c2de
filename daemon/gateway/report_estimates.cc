// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/report_estimates.hpp"

#include "daemon/gateway/report_size.hpp"

namespace mlcca {

bool ReportEstimates::is_large() const {
  std::size_t lines = forwarding_.rules() + gates_.slot_count();
  for (std::size_t n = 0; n < scene_.state->system().networks.size(); ++n)
    if (const auto* table = meshes_.table(n)) lines += table->size();
  return lines > kMostLines || lines + lines_of(*scene_.state, kMostLines - lines) > kMostLines;
}

bool ReportEstimates::has_many_ends(std::size_t channel) const {
  const core::Members& members = scene_.state->members();
  return scene_.state->decisions()[channel].verdicts.size() > kManyEnds ||
         members.publishers_of(channel).size() + members.subscribers_of(channel).size() > kManyEnds;
}

bool ReportEstimates::has_many_lines(std::size_t channel) const {
  if (has_many_ends(channel)) return true;
  std::size_t lines = 0;
  for (const core::Verdict& v : scene_.state->decisions()[channel].verdicts)
    lines += lines_of(*scene_.state, v);
  return lines > kMostLines;
}

bool ReportEstimates::has_channel_of_many_ends() const {
  for (std::size_t c = 0; c < scene_.state->decisions().size(); ++c)
    if (has_many_ends(c)) return true;
  return false;
}

}  // namespace mlcca
