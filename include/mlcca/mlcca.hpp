// SPDX-License-Identifier: BSD-2-Clause
// The complete attribute core: attributes, units, composition, the five checks, and the checks at
// compile time. C++14, freestanding, header-only.
#pragma once
#include "mlcca/arithmetic.hpp"
#include "mlcca/attribute.hpp"
#include "mlcca/attribute_list.hpp"
#include "mlcca/check.hpp"
#include "mlcca/compose.hpp"
#include "mlcca/exact.hpp"
#include "mlcca/satisfies.hpp"
#include "mlcca/static_check.hpp"
#include "mlcca/units.hpp"
