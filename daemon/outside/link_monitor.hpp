// SPDX-License-Identifier: BSD-2-Clause
// What a gateway knows of the interfaces of its machine, as an interface: net::Links of rtnetlink,
// or a fake.
#pragma once
#include <string>

#include "base/result.hpp"

namespace mlcca {

class LinkMonitor {
 public:
  LinkMonitor() = default;
  LinkMonitor(const LinkMonitor&) = delete;
  LinkMonitor& operator=(const LinkMonitor&) = delete;
  LinkMonitor(LinkMonitor&&) = default;
  LinkMonitor& operator=(LinkMonitor&&) = default;
  virtual ~LinkMonitor() = default;

  /// Readable when something has changed.
  [[nodiscard]] virtual int fd() const = 0;
  /// Reads all interfaces again. True: they differ from what was known, or one has gone. After an
  /// error what was known stays.
  virtual Result<bool> refresh() = 0;
  /// Why what is known may be out of date: refresh() soon. Empty: it could be read.
  [[nodiscard]] virtual const std::string& problem() const = 0;
  /// Of an interface, or its index where it is unknown.
  [[nodiscard]] virtual std::string name_of(int ifindex) const = 0;
  /// A filter or a queueing discipline has come, changed or gone since the last call.
  [[nodiscard]] virtual bool take_tc_changed() = 0;
};

}  // namespace mlcca
