// SPDX-License-Identifier: BSD-2-Clause
// Reads the run-time representation directly into the units of a small node, without 64-bit values.
// What the node cannot check is refused. C++14, freestanding.
#pragma once
#include "mlcca/der_decode.hpp"
#include "mlcca/narrow.hpp"

namespace mlcca {
namespace der {

/// A decoded channel in the units of a node. A requirement comes from a publisher or subscriber, a
/// provision from a network.
template <class Units, Side S>
struct NarrowDecoded {
  Role role = S == Side::provision ? Role::network : Role::subscriber;
  uint8_t subject[detail::kSubjectSize] = {};  ///< most significant octet first
  NarrowSet<Units, S> attributes;
};

namespace detail {

template <class Units, Side S>
class NarrowSink {
 public:
  static constexpr size_t kMax = kMaxPlainSize;
  static constexpr bool kTakesUsers = false;

  constexpr bool role(Role role) {
    out_.role = role;
    return (role == Role::network) == (S == Side::provision);
  }
  constexpr bool subject(const uint8_t* octets) {
    uint8_t any = 0;
    for (uint8_t i = 0; i < kSubjectSize; ++i) {
      out_.subject[i] = octets[i];
      any = static_cast<uint8_t>(any | octets[i]);
    }
    return any != 0 || S == Side::provision;
  }
  static constexpr bool takes_marks() { return S == Side::provision; }
  constexpr bool attribute(Attribute a, const uint8_t* magnitude, uint8_t size, bool dynamic) {
    return out_.attributes.set(a, magnitude, size, dynamic);
  }
  constexpr void end_of_attributes() { out_.attributes.normalise(); }
  static constexpr bool users(const Reader<false>&) { return false; }
  constexpr const NarrowDecoded<Units, S>& result() const { return out_; }

 private:
  NarrowDecoded<Units, S> out_;
};

}  // namespace detail

/// Decodes an encoding of at most kMaxPlainSize octets without user-defined attributes: a node
/// cannot check an attribute that it does not know, so it refuses it. If there is an error, *out is
/// unchanged.
template <class Units, Side S>
__attribute__((warn_unused_result)) constexpr Status decode(const uint8_t* data, size_t size,
                                                            NarrowDecoded<Units, S>* out) {
  detail::NarrowSink<Units, S> sink;
  const Status status = detail::read(data, size, sink);
  if (status.ok()) *out = sink.result();
  return status;
}

}  // namespace der
}  // namespace mlcca
