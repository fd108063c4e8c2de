// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/verbs.hpp"

namespace mlcca::tools::design {

void add_generate(CLI::App& app, Context& /*context*/) { app.add_subcommand("generate"); }

}  // namespace mlcca::tools::design
