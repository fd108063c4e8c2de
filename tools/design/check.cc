// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/verbs.hpp"

namespace mlcca::tools::design {

void add_check(CLI::App& app, Context& /*context*/) { app.add_subcommand("check"); }

}  // namespace mlcca::tools::design
