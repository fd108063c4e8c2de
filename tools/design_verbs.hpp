// SPDX-License-Identifier: BSD-2-Clause
// Verbs that another program carries out: mlcca-design, beside mlccactl in a build tree, in
// ../libexec/mlcca where it is installed.
#pragma once
#include <array>
#include <span>
#include <string_view>

#include "tools/exit.hpp"

namespace mlcca::tools {

struct DesignVerb {
  const char* name;
  const char* help;
};
inline constexpr std::array kDesignVerbs = {
    DesignVerb{"analyse-bus", "response times of the messages of a CAN bus"},
    DesignVerb{"check", "find what cannot work in the description of a system"},
    DesignVerb{"describe", "create and edit the description of an event channel"},
    DesignVerb{"generate", "C++ and DER from the description of a system"},
};

/// The first word that is no option names a verb of design time.
bool is_design_time(std::span<char*> arguments);

/// The verb gate with --verify: mlcca-readback carries it out, without the daemon.
bool is_read_back(std::span<char*> arguments);

/// Becomes that program, with the same arguments. Returns only if it cannot be started, which has
/// been said then.
Exit become_design(char** arguments);
Exit become_readback(char** arguments);

}  // namespace mlcca::tools
