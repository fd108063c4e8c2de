// SPDX-License-Identifier: BSD-2-Clause
// No profile: frames do not name a subject. A stated binding is an identifier all the same.
#include "core/profiles/definition.hpp"

namespace mlcca::core::profiles {

constinit const ProfileTraits none{.element = "nothing",
                                   .names_channels = false,
                                   .form = IdentifierForm::stated,
                                   .problems = problems_of_identifier,
                                   .identity = plain,
                                   .overlap = overlap,
                                   .number_text = kIdentifierText};

}  // namespace mlcca::core::profiles
