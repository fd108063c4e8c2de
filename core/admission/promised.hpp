// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstddef>

#include "core/admission/admission.hpp"
#include "core/reserve/parts.hpp"

namespace mlcca::core {

/// What is promised of a shared network beside what this gateway carries: to other gateways, by
/// what they have reserved; and to publishers that are here, by what is reserved or stands in the
/// description for them. `view`: of a mesh, its links as they are now; null: they are not known.
[[nodiscard]] Others promised_beside(const Situation& situation, std::size_t network,
                                     const MeshView* view);

}  // namespace mlcca::core
