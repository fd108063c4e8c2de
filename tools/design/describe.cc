// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/verbs.hpp"

namespace mlcca::tools::design {

void add_describe(CLI::App& app, Context& /*context*/) { app.add_subcommand("describe"); }

}  // namespace mlcca::tools::design
