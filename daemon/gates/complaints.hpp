// SPDX-License-Identifier: BSD-2-Clause
// Collects what libbpf would print, for the text of an error.
#pragma once
#include <string>

#include "base/result.hpp"

namespace mlcca::gates {

/// While an object lives, libbpf's warnings are added to it. Objects may be nested; the innermost
/// one collects. libbpf's print function has no user data, so a global variable of the .cc file
/// names that one.
class Complaints {
 public:
  Complaints();
  Complaints(const Complaints&) = delete;
  Complaints& operator=(const Complaints&) = delete;
  Complaints(Complaints&&) = delete;
  Complaints& operator=(Complaints&&) = delete;
  ~Complaints();

  /// The error of a failed call: "CALL: Operation not permitted (libbpf: …)". `error` is a negative
  /// or positive errno.
  [[nodiscard]] std::unexpected<Error> error(const std::string& call, int error) const;
  void add(const std::string& line);

 private:
  Complaints* outer_;
  std::string text_;
};

}  // namespace mlcca::gates
