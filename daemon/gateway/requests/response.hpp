// SPDX-License-Identifier: BSD-2-Clause
// What a handler gives for a request.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "daemon/serve/server.hpp"

namespace mlcca {

using Body = decltype(control::Reply::body);

/// Who has asked, and how the reply may come.
struct Asker {
  serve::Peer peer;
  bool may_slice = false;
};

struct Response {
  // NOLINTBEGIN(google-explicit-constructor,hicpp-explicit-conversions): a body is a whole response
  Response(Body whole) : body(std::move(whole)) {}
  template <class Part>
    requires std::constructible_from<Body, Part>
  Response(Part part) : body(std::move(part)) {}
  // NOLINTEND(google-explicit-constructor,hicpp-explicit-conversions)
  /// In slices: `next` makes them.
  explicit Response(serve::NextSlice next, std::size_t least = 0)
      : slices(std::move(next)), least_bytes(least) {}

  Body body;
  bool held = false;                       ///< not sent before what it says is on disk
  core::AdmissionId owned = 0;             ///< whose events go to the connection from now on
  std::optional<std::uint64_t> follows{};  ///< subject whose events go to it from now on
  serve::NextSlice slices;
  std::size_t least_bytes = 0;  ///< that all slices have together, as far as that is known
};

[[nodiscard]] inline control::Error error_of(control::ErrorKind kind, std::string message) {
  return {kind, std::move(message), {}};
}
/// What was asked for makes no sense.
[[nodiscard]] inline control::Error invalid(std::string message) {
  return error_of(control::ErrorKind::invalid, std::move(message));
}
/// It made sense and could not be done.
[[nodiscard]] inline control::Error failed(std::string message) {
  return error_of(control::ErrorKind::world, std::move(message));
}

}  // namespace mlcca
