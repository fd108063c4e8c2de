// SPDX-License-Identifier: BSD-2-Clause
// Attribute values in generated code: as types of mlcca/attribute_list.hpp and as DER.
#pragma once
#include <map>
#include <string>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "mlcca/der_format.hpp"

namespace mlcca::tools::design {

/// The name of the struct that is generated for each user-defined attribute, by its index in the
/// system.
using UserTypes = std::map<std::uint32_t, std::string>;

/// A type such as "mlcca::AttributeList<mlcca::Period<50_ms>, mlcca::Omission<2>>", with one
/// attribute on a line (figure 3 of the paper). A literal has the largest unit of which the value
/// is an integral multiple. `user` must contain every attribute of `values`.
std::string attribute_list(const AttributeSet& set, const core::UserValues& values,
                           const UserTypes& user);

/// A literal that has the same unsigned type for every compiler.
std::string number(Value value);

/// The DER encoding of an end by proto/mlcca.asn1. An error says why it cannot be encoded.
Result<std::string> der_of(const core::System& system, der::Role role, core::Subject subject,
                           const AttributeSet& set, const core::UserValues& values);

/// The values in the order that DER requires: by the bytes of their names.
core::UserValues sorted_by_name(const core::System& system, core::UserValues values);

}  // namespace mlcca::tools::design
