// SPDX-License-Identifier: BSD-2-Clause
// No profile: frames name nothing, so that there is no subject. What a binding states all the same
// is an identifier.
#include "core/profiles/definition.hpp"

namespace mlcca::core::profiles {

constinit const ProfileTraits none{.element = "nothing",
                                   .form = IdentifierForm::stated,
                                   .problems = problems_of_identifier,
                                   .identity = plain,
                                   .overlap = overlap};

}  // namespace mlcca::core::profiles
