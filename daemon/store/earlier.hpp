// SPDX-License-Identifier: BSD-2-Clause
// The store of MLCCA before there was a journal: one file `admissions`, written as a whole.
#pragma once
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "daemon/store/contents.hpp"

namespace mlcca::store {

/// What the file at `path` says, whose bytes are `text`. A damaged one is an error that names it
/// and says what to do.
Result<Contents> read_earlier(std::string_view text, const std::string& path);

}  // namespace mlcca::store
