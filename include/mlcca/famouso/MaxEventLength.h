// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's MaxEventLength, in the global namespace: bytes, the other name of MaxPayload.
#pragma once
#include "mlcca/attribute_list.hpp"

/// Payload bytes of one event.
template <uint32_t v>
struct MaxEventLength {
  using type = MaxEventLength;
  static constexpr uint32_t value = v;
  static constexpr uint8_t kCode = mlcca::detail::code_of(mlcca::Attribute::max_payload);
  static constexpr mlcca::Value kValue = v;
};
