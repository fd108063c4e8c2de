// SPDX-License-Identifier: BSD-2-Clause
// No profile: frames do not name a subject. A stated binding is an identifier all the same.
#include "core/profiles/definition.hpp"

namespace mlcca::core::profiles {

constinit const ProfileTraits none{.element = "nothing",
                                   .form = IdentifierForm::stated,
                                   .problems = problems_of_identifier,
                                   .identity = plain,
                                   .overlap = overlap};

}  // namespace mlcca::core::profiles
