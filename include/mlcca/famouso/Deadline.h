// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's Deadline, in the global namespace: ms.
#pragma once
#include "mlcca/attribute_list.hpp"

/// Time from publication to delivery, in ms, at most.
template <uint32_t v>
struct Deadline {
  using type = Deadline;
  static constexpr uint32_t value = v;
  static constexpr uint8_t kCode = mlcca::detail::code_of(mlcca::Attribute::deadline);
  static constexpr mlcca::Value kValue = mlcca::Value{v} * 1000000;
};
