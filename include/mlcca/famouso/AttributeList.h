// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's AttributeList, in the global namespace: the list proper is its ::type.
#pragma once
#include "mlcca/attribute_list.hpp"

/// Attributes of this folder, each at most once.
template <class... As>
struct AttributeList {
  using type = mlcca::AttributeList<As...>;
};
