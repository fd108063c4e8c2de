// SPDX-License-Identifier: BSD-2-Clause
// Attribute values as the types of mlcca/attribute_list.hpp, and as DER.
#pragma once
#include <map>
#include <string>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "mlcca/der_format.hpp"

namespace mlcca::tools::design {

/// The struct that stands for each user-defined attribute, by its index in the system.
using UserTypes = std::map<std::uint32_t, std::string>;

/// "mlcca::AttributeList<mlcca::Period<50_ms>, mlcca::Omission<2>>", an attribute on a line, as in
/// figure 3 of the paper. A literal is in the largest
/// unit of which the value is a whole multiple. `user` names every attribute that is in `values`.
std::string attribute_list(const AttributeSet& set, const core::UserValues& values,
                           const UserTypes& user);

/// An unsigned number that has the same type for every compiler.
std::string number(Value value);

/// The run-time representation of an end, proto/mlcca.asn1. The error says why there is none.
Result<std::string> der_of(const core::System& system, der::Role role, core::Subject subject,
                           const AttributeSet& set, const core::UserValues& values);

/// The user-defined values in the order of DER: by the bytes of their names.
core::UserValues sorted_by_name(const core::System& system, core::UserValues values);

}  // namespace mlcca::tools::design
