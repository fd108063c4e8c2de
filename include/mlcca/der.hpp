// SPDX-License-Identifier: BSD-2-Clause
// The run-time representation (DER) of an event channel's attributes, defined in proto/mlcca.asn1:
// writer and reader. C++14, freestanding. docs/reference/nodes.md describes the format as a table.
#pragma once
#include "mlcca/der_decode.hpp"
#include "mlcca/der_encode.hpp"
#include "mlcca/der_format.hpp"
