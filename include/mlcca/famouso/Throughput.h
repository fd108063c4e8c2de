// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's Throughput, in the global namespace: bytes/s, the later name of Bandwidth.
#pragma once
#include "mlcca/attribute_list.hpp"

/// Payload bytes per second, at least.
template <uint32_t v>
struct Throughput {
  using type = Throughput;
  static constexpr uint32_t value = v;
  static constexpr uint8_t kCode = mlcca::detail::code_of(mlcca::Attribute::bandwidth);
  static constexpr mlcca::Value kValue = v;
};
