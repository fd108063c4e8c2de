// SPDX-License-Identifier: BSD-2-Clause
// The generated enumeration that an exception handler receives; generated.hpp of libmlcca maps to
// it.
#pragma once
#include <string_view>

namespace mlcca::tools::design {

inline constexpr std::string_view kChannelExceptionText =
    "/// Why an exception handler is called.\n"
    "enum class ChannelException : uint8_t {\n"
    "  refused,    ///< the channel was not admitted\n"
    "  withdrawn,  ///< it was, and the network can no longer carry it\n"
    "  switched,   ///< another of its attribute sets is in force now\n"
    "  violated,   ///< an event was late, lost or could not be sent as specified\n"
    "  granted,    ///< it was refused or withdrawn, and is admitted now\n"
    "  restored,   ///< events that were missing come again\n"
    "  unknown,    ///< what decides is gone: what is admitted holds for a while\n"
    "  known,      ///< it is back, and has decided\n"
    "};\n\n";

}  // namespace mlcca::tools::design
