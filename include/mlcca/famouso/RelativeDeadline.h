// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's RelativeDeadline, in the global namespace: us, the later name of a Deadline that counts
// from now.
#pragma once
#include "mlcca/attribute_list.hpp"

/// Time from publication to delivery, in us, at most.
template <uint32_t v>
struct RelativeDeadline {
  using type = RelativeDeadline;
  static constexpr uint32_t value = v;
  static constexpr uint8_t kCode = mlcca::detail::code_of(mlcca::Attribute::deadline);
  static constexpr mlcca::Value kValue = mlcca::Value{v} * 1000;
};
