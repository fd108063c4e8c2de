// SPDX-License-Identifier: BSD-2-Clause
// The verbs that other programs carry out. Their programs are in the folder of mlccactl in a build
// tree, and in ../libexec/mlcca once installed.
#pragma once
#include <array>
#include <span>
#include <string_view>

#include "tools/exit.hpp"

namespace mlcca::tools {

/// A program that carries out verbs.
struct Program {
  const char* name;
  const char* what;  ///< text for a user on whose machine the program is not installed
};
inline constexpr Program kDesign{"mlcca-design",
                                 "The verbs of design time are a program of their own"};
inline constexpr Program kReadback{"mlcca-readback",
                                   "Reading back without the daemon is a program of its own"};
inline constexpr Program kDoctor{"mlcca-doctor", "The doctor is a program of its own"};

/// A verb and the program that carries it out; `help` is its line in the help of mlccactl.
struct OtherVerb {
  const char* name;
  const char* help;
  const Program* program;
};
inline constexpr std::array kOtherVerbs = {
    OtherVerb{"analyse-bus", "response times of the messages of a CAN bus", &kDesign},
    OtherVerb{"check", "find what cannot work in the description of a system", &kDesign},
    OtherVerb{"describe", "create and edit the description of an event channel", &kDesign},
    OtherVerb{"export", "what a description admits, for other tools", &kDesign},
    OtherVerb{"format", "attributes of a description in the short form or the paper's", &kDesign},
    OtherVerb{"generate", "C++ and DER from the description of a system", &kDesign},
    OtherVerb{"learn", "draft a description from the traffic that is there; asks no daemon",
              &kDesign},
    OtherVerb{"import", "describe a network from DBC, CANopen, Cyphal, ROS 2 or DDS files",
              &kDesign},
    OtherVerb{"new", "the first description of a system", &kDesign},
    OtherVerb{"rollout", "one description for all gateways of a cluster", &kDesign},
    OtherVerb{"doctor", "examine a CAN controller before it is trusted; asks no daemon", &kDoctor},
};

/// The program for the verb of a command line (the first word that is no option; gate only with
/// --verify); nullptr if mlccactl carries it out itself.
const Program* program_for(std::span<char*> arguments);

/// Replaces this process by the program, with the same arguments. Returns only if it cannot be
/// started, after an error message.
Exit become(const Program& program, char** arguments);

}  // namespace mlcca::tools
