// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/admission/permits.hpp"

namespace mlcca::core {

/// What has changed in permits since they were polled last.
class PermitWatch {
 public:
  /// Something of a network may not be held any more.
  struct Ended {
    std::size_t network = 0;
    std::uint64_t since = 0;  ///< see Permits::ended_since()
  };
  struct Changes {
    std::vector<std::size_t> networks;  ///< of which more, or less, may be held
    std::vector<Ended> ended;
    std::optional<std::uint64_t> disagreed_since;  ///< see Permits::disagreed_since()
    bool more = false;  ///< something may be held, or is agreed to, that was not
  };

  /// Nothing is known of the permits of so many networks.
  void reset(std::size_t networks);
  /// Whether nothing has changed.
  [[nodiscard]] bool has_seen(const Permits& permits) const;
  [[nodiscard]] Changes poll(const Permits& permits);

 private:
  std::vector<std::uint64_t> grown_, shrunk_;  ///< by network
  std::uint64_t more_agreed_ = 0, less_agreed_ = 0;
};

}  // namespace mlcca::core
