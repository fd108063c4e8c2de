// SPDX-License-Identifier: BSD-2-Clause
// The emergency switch of the paper and its own bus.
#pragma once
#include "mlcca/attribute_list.hpp"

using namespace mlcca::literals;

using SwitchNeeds = mlcca::AttributeList<mlcca::Period<50_ms>, mlcca::Omission<2>>;
using OwnBus = mlcca::AttributeList<mlcca::Period<10_ms>, mlcca::Omission<2>>;
