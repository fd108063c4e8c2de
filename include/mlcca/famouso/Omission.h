// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's Omission, in the global namespace: events.
#pragma once
#include "mlcca/attribute_list.hpp"

/// Events lost in a row, at most.
template <uint32_t v>
struct Omission {
  using type = Omission;
  static constexpr uint32_t value = v;
  static constexpr uint8_t kCode = mlcca::detail::code_of(mlcca::Attribute::omission);
  static constexpr mlcca::Value kValue = v;
};
