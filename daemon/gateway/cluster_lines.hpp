// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "base/outage.hpp"
#include "daemon/gateway/event_log.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca {

/// What the log says about the cluster: each line when it is new, and not more than others can make
/// new ones.
class ClusterLines {
 public:
  explicit ClusterLines(EventLog& log) : log_(log) {}

  /// The standing of this gateway; empty: it takes part. `lost`: the store does not answer. While
  /// that lasts, the reason may change, with each member of the store that is tried.
  void standing(const std::string& system, const std::string& why, bool lost, Value now);
  /// The store may have other troubles now.
  void invalidate() { invalid_ = true; }
  /// Troubles of the store, if they are invalid and lines are due.
  void troubles(const std::function<std::vector<std::string>()>& find, Value now);

 private:
  EventLog& log_;
  std::string said_;                   ///< the latest line about the standing
  std::vector<std::string> troubles_;  ///< the latest lines about the store
  Value next_ = 0;                     ///< others are not reported before that
  bool invalid_ = true;                ///< the troubles have to be found again
  Outage outage_;                      ///< of the store, as it is reported
};

}  // namespace mlcca
