// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's Jitter, in the global namespace: us.
#pragma once
#include "mlcca/attribute_list.hpp"

/// Longest latency minus shortest one, in us.
template <uint32_t v>
struct Jitter {
  using type = Jitter;
  static constexpr uint32_t value = v;
  static constexpr uint8_t kCode = mlcca::detail::code_of(mlcca::Attribute::jitter);
  static constexpr mlcca::Value kValue = mlcca::Value{v} * 1000;
};
