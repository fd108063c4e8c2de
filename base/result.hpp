// SPDX-License-Identifier: BSD-2-Clause
// A value, or an error text for a person if the outside world (kernel, file, peer, input) did not
// give it.
#pragma once
#include <expected>
#include <string>
#include <utility>

namespace mlcca {

/// The text names the call or field that failed and what would be right; callers on the way up put
/// context in front.
struct Error {
  std::string text;
};

template <class T>
using Result = std::expected<T, Error>;

inline std::unexpected<Error> fail(std::string text) {
  return std::unexpected<Error>(Error{std::move(text)});
}

}  // namespace mlcca
