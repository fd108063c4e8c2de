// SPDX-License-Identifier: BSD-2-Clause
// A value or the reason why the outside world did not give it, in words for a person.
#pragma once
#include <expected>
#include <string>
#include <utility>

namespace mlcca {

/// Names the failed call or field and what would be right; gains context on its way up.
struct Error {
  std::string text;
};

template <class T>
using Result = std::expected<T, Error>;

inline std::unexpected<Error> fail(std::string text) {
  return std::unexpected<Error>(Error{std::move(text)});
}

}  // namespace mlcca
