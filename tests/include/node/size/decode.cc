// SPDX-License-Identifier: BSD-2-Clause
// The whole of what a node does at run time: reads an encoding that came in, and figure 5.
#include "frame.hpp"
#include "mlcca/der_narrow.hpp"
#include "needs.hpp"

#ifndef UNITS
#define UNITS mlcca::Units16
#endif

namespace {
uint8_t received[mlcca::der::kMaxPlainSize];
constexpr auto kGiven = mlcca::narrow<UNITS, mlcca::Side::provision, OwnBus>();
}  // namespace

void run() {
  asm volatile("" : : "r"(&received) : "memory");
  mlcca::der::NarrowDecoded<UNITS, mlcca::Side::requirement> needs;
  if (!mlcca::der::decode(received, incoming, &needs).ok()) {
    outgoing = 0xff;
    return;
  }
  outgoing = mlcca::check_layer(needs.attributes, kGiven).unfit;
}
