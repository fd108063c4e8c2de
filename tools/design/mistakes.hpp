// SPDX-License-Identifier: BSD-2-Clause
// Checks a generated description before it is written: a verb must not write one that the daemon
// cannot read.
#pragma once
#include <optional>
#include <string>

#include "description/kinds.hpp"
#include "description/read.hpp"
#include "tools/design/say.hpp"

namespace mlcca::tools::design {

/// Why `text`, a description that a verb has generated, is not written; nullopt if it can be read.
/// `name` is its name in the details.
inline std::optional<Refusal> mistakes_in(
    const std::string& text, const std::string& name,
    description::Users users = description::Users::of_this_machine) {
  const auto read = description::read_memory(text, name, {}, users);
  if (read) return std::nullopt;
  Refusal out{Exit::usage, "the description would have mistakes; nothing was written", {}};
  out.details.reserve(read.error().size());
  for (const auto& problem : description::shortened(read.error()))
    out.details.push_back(description::to_string(problem));
  return out;
}

}  // namespace mlcca::tools::design
