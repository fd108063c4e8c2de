// SPDX-License-Identifier: BSD-2-Clause
// A composition that only a network's rate has.
// expect: static
// expect: an attribute of the user's own has no medium
// lines: 20
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;
template <mlcca::Value V>
struct Share
    : mlcca::UserAttribute<Share, V, mlcca::Better::larger, mlcca::Composition::shared_medium> {};
Share<1> share;
