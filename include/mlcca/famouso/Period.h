// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's Period, in the global namespace: ms, as in the paper.
#pragma once
#include "mlcca/attribute_list.hpp"

/// Time between two events, in ms.
template <uint32_t v>
struct Period {
  using type = Period;
  static constexpr uint32_t value = v;
  static constexpr uint8_t kCode = mlcca::detail::code_of(mlcca::Attribute::period);
  static constexpr mlcca::Value kValue = mlcca::Value{v} * 1000000;
};
