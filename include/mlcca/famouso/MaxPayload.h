// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's MaxPayload, in the global namespace: bytes.
#pragma once
#include "mlcca/attribute_list.hpp"

/// Payload bytes of one event.
template <uint32_t v>
struct MaxPayload {
  using type = MaxPayload;
  static constexpr uint32_t value = v;
  static constexpr uint8_t kCode = mlcca::detail::code_of(mlcca::Attribute::max_payload);
  static constexpr mlcca::Value kValue = v;
};
