// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/check/write.hpp"

namespace mlcca::tools::design {

std::string write_html(const Report& report) { return write_text(report, Color::no); }

}  // namespace mlcca::tools::design
