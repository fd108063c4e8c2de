// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/check/write.hpp"

namespace mlcca::tools::design {

std::string write_sarif(const Report& report) { return write_json(report); }

}  // namespace mlcca::tools::design
