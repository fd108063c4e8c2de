// SPDX-License-Identifier: BSD-2-Clause
// Reads the run-time representation straight into the units of a small node: no 64-bit value is
// made, and what the node cannot check it refuses. C++14, freestanding.
#pragma once
#include "mlcca/der_decode.hpp"
#include "mlcca/narrow.hpp"

namespace mlcca {
namespace der {

/// What an encoding says, in the units of a node. A requirement comes from a publisher or
/// subscriber, a provision from a network.
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

/// Reads an encoding of `size` octets, at most kMaxPlainSize, without user attributes: a node that
/// does not know an attribute cannot check it, so it refuses. On an error *out is left alone.
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
