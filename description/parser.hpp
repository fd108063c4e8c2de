// SPDX-License-Identifier: BSD-2-Clause
// libxml2's event parser over one source, and nothing else of libxml2.
#pragma once
#include <functional>

#include "description/builder.hpp"
#include "description/source.hpp"

namespace mlcca::description {

/// Called before bytes are used, with their number. False: nothing more is read.
using Account = std::function<bool(std::size_t bytes)>;

/// Hands the events of `source`, which is the builder's current file `file`, to `builder`, until
/// the document ends, is not well-formed or the builder has stopped. Opens nothing. What is wrong
/// is reported to the builder.
void parse_document(Source& source, std::uint32_t file, Builder& builder, const Account& account);

}  // namespace mlcca::description
