// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/check/page.hpp"

namespace mlcca::tools::design {
namespace {

#include "check_page.inc"

}  // namespace

std::string_view page_style() { return kStyle; }
std::string_view page_script() { return kScript; }
std::string_view page_script_hash() { return kScriptHash; }

}  // namespace mlcca::tools::design
