// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's PacketLoss, in the global namespace: hundredths of a percent, so 1498 is 14.98 %.
#pragma once
#include "mlcca/attribute_list.hpp"

/// Share of the events that are lost, in hundredths of a percent.
template <uint16_t v>
struct PacketLoss {
  using type = PacketLoss;
  static constexpr uint16_t value = v;
  static constexpr uint8_t kCode = mlcca::detail::code_of(mlcca::Attribute::packet_loss);
  static constexpr mlcca::Value kValue = mlcca::Value{v} * 100000;
};
