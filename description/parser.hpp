// SPDX-License-Identifier: BSD-2-Clause
// Reads one document with the SAX parser of libxml2. Only this part of libxml2 is used.
#pragma once
#include <functional>

#include "description/builder.hpp"
#include "description/source.hpp"

namespace mlcca::description {

/// Called with the number of bytes before they are used. Returns false to end the reading.
using Account = std::function<bool(std::size_t bytes)>;

/// Passes the events of `source` to `builder`, in which it is the current file with number `file`,
/// until the document ends, is not well-formed, or the builder has stopped. It opens no files.
/// Problems are reported to the builder.
void parse_document(Source& source, std::uint32_t file, Builder& builder, const Account& account);

}  // namespace mlcca::description
