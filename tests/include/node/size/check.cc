// SPDX-License-Identifier: BSD-2-Clause
// Figure 5 at run time: a requirement in RAM against the constant provision of the own network.
#include "frame.hpp"
#include "mlcca/narrow.hpp"
#include "needs.hpp"

#ifndef UNITS
#define UNITS mlcca::Units16
#endif

namespace {
mlcca::NarrowRequirement<UNITS> needs =
    mlcca::narrow<UNITS, mlcca::Side::requirement, SwitchNeeds>();
constexpr auto kGiven = mlcca::narrow<UNITS, mlcca::Side::provision, OwnBus>();
}  // namespace

void run() {
  asm volatile("" : : "r"(&needs) : "memory");
  outgoing = mlcca::check_layer(needs, kGiven).unfit;
}
