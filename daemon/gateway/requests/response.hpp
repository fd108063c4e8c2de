// SPDX-License-Identifier: BSD-2-Clause
// The result of a handler.
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

/// Who has asked, and whether the reply may come in slices.
struct Asker {
  serve::Peer peer;
  bool may_slice = false;
};

/// The reply to a request, complete or in slices, and what it means for the connection.
struct Response {
  // NOLINTBEGIN(google-explicit-constructor,hicpp-explicit-conversions): a body is a whole response
  Response(Body whole) : body(std::move(whole)) {}
  template <class Part>
    requires std::constructible_from<Body, Part>
  Response(Part part) : body(std::move(part)) {}
  // NOLINTEND(google-explicit-constructor,hicpp-explicit-conversions)
  /// A reply in slices, which `next` makes.
  explicit Response(serve::NextSlice next, std::size_t least = 0)
      : slices(std::move(next)), least_bytes(least) {}

  Body body;
  bool held = false;                       ///< not sent before everything that it says is on disk
  core::AdmissionId owned = 0;             ///< its events go to the connection from now on; 0: none
  std::optional<std::uint64_t> follows{};  ///< the subject whose events go to it from now on
  serve::NextSlice slices;
  std::size_t least_bytes = 0;  ///< the least size of all slices together, as far as known
};

[[nodiscard]] inline control::Error error_of(control::ErrorKind kind, std::string message) {
  return {kind, std::move(message), {}};
}
/// An error: the request makes no sense.
[[nodiscard]] inline control::Error invalid(std::string message) {
  return error_of(control::ErrorKind::invalid, std::move(message));
}
/// An error: the request makes sense, but could not be carried out.
[[nodiscard]] inline control::Error failed(std::string message) {
  return error_of(control::ErrorKind::world, std::move(message));
}

}  // namespace mlcca
