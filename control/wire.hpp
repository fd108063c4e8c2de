// SPDX-License-Identifier: BSD-2-Clause
// Between the plain structs and the generated protobuf classes; private to control/.
#pragma once
#include "base/result.hpp"
#include "control/messages.hpp"
#include "mlcca/v1/control.pb.h"

namespace mlcca::control {

void to_wire(const Request& from, v1::Request& to);
void to_wire(const Reply& from, v1::Reply& to);

/// Moves texts out of `from`. An error when the body is one that we do not know.
Result<Request> from_wire(v1::Request& from);
Result<Reply> from_wire(v1::Reply& from);

}  // namespace mlcca::control
