// SPDX-License-Identifier: BSD-2-Clause
// An interface for what a gateway knows about the interfaces of its machine: net::Links, which uses
// rtnetlink, or a fake.
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

  /// Readable if something has changed.
  [[nodiscard]] virtual int fd() const = 0;
  /// Reads all interfaces again. True if they differ from what was known, or one has gone. After an
  /// error what was known stays.
  virtual Result<bool> refresh() = 0;
  /// Why the known state may be out of date, so that refresh() is to be called soon; empty if it
  /// could be read.
  [[nodiscard]] virtual const std::string& problem() const = 0;
  /// The name of an interface; its index in digits if it is unknown.
  [[nodiscard]] virtual std::string name_of(int ifindex) const = 0;
  /// Whether a filter or a queueing discipline has appeared, changed or gone since the last call.
  [[nodiscard]] virtual bool take_tc_changed() = 0;
};

}  // namespace mlcca
