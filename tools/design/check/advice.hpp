// SPDX-License-Identifier: BSD-2-Clause
// What each kind of finding means and what helps: a sentence or two beside the table of
// core/design/findings.hpp, for rule lists of editors and code hosts, the HTML report and
// docs/reference/check.md.
#pragma once
#include "core/design/findings.hpp"

namespace mlcca::tools::design {

/// Never empty.
const char* advice_on(core::FindingId id);

}  // namespace mlcca::tools::design
