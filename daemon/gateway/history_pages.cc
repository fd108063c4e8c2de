// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/history_pages.hpp"

#include <algorithm>

namespace mlcca {

Result<control::History> HistoryPages::next() {
  const std::size_t wanted = std::min(left_, kPage);
  filter_.limit = wanted + again_;
  auto found = history_.query(filter_);
  if (!found) return std::unexpected(found.error());
  control::History out;
  for (std::size_t i = again_; i < found->size(); ++i) {
    store::Decision& d = (*found)[i];
    again_ = d.unix_ns == filter_.until_ns ? again_ + 1 : 1;
    filter_.until_ns = d.unix_ns;
    out.entries.push_back({d.unix_ns, std::move(d.kind), d.subject, std::move(d.channel),
                           std::move(d.from), std::move(d.to), std::move(d.network),
                           std::move(d.message), std::move(d.by)});
  }
  left_ = out.entries.size() < wanted ? 0 : left_ - wanted;
  return out;
}

}  // namespace mlcca
