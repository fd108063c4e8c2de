// SPDX-License-Identifier: BSD-2-Clause
// The whole attribute core: attributes, units, composition and the five checks.
// C++14, freestanding, header-only.
#pragma once
#include "mlcca/arithmetic.hpp"
#include "mlcca/attribute.hpp"
#include "mlcca/check.hpp"
#include "mlcca/compose.hpp"
#include "mlcca/exact.hpp"
#include "mlcca/satisfies.hpp"
#include "mlcca/units.hpp"
