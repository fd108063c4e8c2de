// SPDX-License-Identifier: BSD-2-Clause
// Enumerations of the control protocol: what a peer says that nobody knows is the safe one of each.
#pragma once
#include "control/parts.hpp"
#include "mlcca/v1/control.pb.h"

namespace mlcca::control {

HealthState health_state(v1::HealthState from);
ErrorKind error_kind(v1::ErrorKind from);
Outcome outcome(v1::Outcome from);
v1::HealthState to_wire(HealthState state);
v1::ErrorKind to_wire(ErrorKind kind);
v1::Outcome to_wire(Outcome outcome);

}  // namespace mlcca::control
