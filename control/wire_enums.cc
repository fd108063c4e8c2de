// SPDX-License-Identifier: BSD-2-Clause
#include "control/wire_enums.hpp"

namespace mlcca::control {

HealthState health_state(v1::HealthState from) {
  switch (from) {
    case v1::HEALTH_HEALTHY:
      return HealthState::healthy;
    case v1::HEALTH_DEGRADED:
      return HealthState::degraded;
    case v1::HEALTH_CLOSED:
      return HealthState::closed;
    default:
      return HealthState::unknown;
  }
}

ErrorKind error_kind(v1::ErrorKind from) {
  switch (from) {
    case v1::ERROR_INVALID:
      return ErrorKind::invalid;
    case v1::ERROR_FORBIDDEN:
      return ErrorKind::forbidden;
    case v1::ERROR_UNREADABLE:
      return ErrorKind::unreadable;
    case v1::ERROR_WORLD:
      return ErrorKind::world;
    default:
      return ErrorKind::unspecified;
  }
}

Outcome outcome(v1::Outcome from) {
  switch (from) {
    case v1::OUTCOME_FIT:
      return Outcome::fit;
    case v1::OUTCOME_RUN_TIME:
      return Outcome::run_time;
    default:
      return Outcome::unfit;
  }
}

v1::HealthState to_wire(HealthState state) {
  switch (state) {
    case HealthState::healthy:
      return v1::HEALTH_HEALTHY;
    case HealthState::degraded:
      return v1::HEALTH_DEGRADED;
    case HealthState::closed:
      return v1::HEALTH_CLOSED;
    case HealthState::unknown:
      break;
  }
  return v1::HEALTH_UNKNOWN;
}

v1::ErrorKind to_wire(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::invalid:
      return v1::ERROR_INVALID;
    case ErrorKind::forbidden:
      return v1::ERROR_FORBIDDEN;
    case ErrorKind::unreadable:
      return v1::ERROR_UNREADABLE;
    case ErrorKind::world:
      return v1::ERROR_WORLD;
    case ErrorKind::unspecified:
      break;
  }
  return v1::ERROR_UNSPECIFIED;
}

v1::Outcome to_wire(Outcome outcome) {
  switch (outcome) {
    case Outcome::fit:
      return v1::OUTCOME_FIT;
    case Outcome::run_time:
      return v1::OUTCOME_RUN_TIME;
    case Outcome::unfit:
      break;
  }
  return v1::OUTCOME_UNFIT;
}

}  // namespace mlcca::control
