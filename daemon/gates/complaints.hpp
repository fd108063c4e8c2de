// SPDX-License-Identifier: BSD-2-Clause
// What libbpf would print, kept for an error text instead.
#pragma once
#include <string>

#include "base/result.hpp"

namespace mlcca::enforce {

/// While one lives, libbpf's warnings go into it; they nest. libbpf's print function has no user
/// data, so the innermost one is known to this file alone.
class Complaints {
 public:
  Complaints();
  Complaints(const Complaints&) = delete;
  Complaints& operator=(const Complaints&) = delete;
  Complaints(Complaints&&) = delete;
  Complaints& operator=(Complaints&&) = delete;
  ~Complaints();

  /// "CALL: Operation not permitted (libbpf: …)"; `error` is a negative or positive errno.
  [[nodiscard]] std::unexpected<Error> error(const std::string& call, int error) const;
  void add(const std::string& line);

 private:
  Complaints* outer_;
  std::string text_;
};

}  // namespace mlcca::enforce
