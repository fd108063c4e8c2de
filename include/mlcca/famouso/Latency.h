// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's Latency, in the global namespace: us.
#pragma once
#include "mlcca/attribute_list.hpp"

/// Time from sending to receiving, in us, at most.
template <uint32_t v>
struct Latency {
  using type = Latency;
  static constexpr uint32_t value = v;
  static constexpr uint8_t kCode = mlcca::detail::code_of(mlcca::Attribute::latency);
  static constexpr mlcca::Value kValue = mlcca::Value{v} * 1000;
};
