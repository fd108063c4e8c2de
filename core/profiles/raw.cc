// SPDX-License-Identifier: BSD-2-Clause
// Raw CAN: the 11-bit or 29-bit identifier itself identifies the subject.
#include "base/number.hpp"
#include "core/profiles/definition.hpp"

namespace mlcca::core::profiles {

std::vector<std::string> problems_of_identifier(const Binding& b) {
  std::vector<std::string> out;
  if (b.id > (b.extended ? kExtendedBits : kStandardBits))
    out.push_back(
        b.extended ? "extended identifier " + hexadecimal(b.id) + " is too large: up to 0x1fffffff"
                   : "standard identifier " + hexadecimal(b.id) +
                         " is too large: up to 0x7ff, or form=\"extended\" up to 0x1fffffff");
  if (b.extended && b.format == FrameFormat::xl)
    out.emplace_back("CAN XL has priorities of 11 bits: form=\"standard\"");
  if (!b.is_masked()) return out;
  if (b.mask == 0)
    out.emplace_back("mask 0x0 is every frame: state the bits of the identifier that count");
  else if ((b.id & ~b.mask) != 0)
    out.push_back("identifier " + hexadecimal(b.id) + " has bits that mask " + hexadecimal(b.mask) +
                  " leaves open: write " + hexadecimal(b.id & b.mask));
  return out;
}

/// For an 11-bit identifier all 29 bits are compared: those that a standard frame does not have
/// must be 0.
FrameIdentity plain(const Publisher& /*publisher*/, const Binding& b, bool /*fragmented*/) {
  return {.id = b.id,
          .mask = b.extended ? b.mask & kExtendedBits : b.mask | (kExtendedBits & ~kStandardBits)};
}

bool overlap(const Binding& a, const Binding& b) { return ((a.id ^ b.id) & a.mask & b.mask) == 0; }

constinit const ProfileTraits raw{.element = "an Identifier",
                                  .form = IdentifierForm::stated,
                                  .last = kExtendedBits,
                                  .problems = problems_of_identifier,
                                  .identity = plain,
                                  .overlap = overlap,
                                  .number_text = kIdentifierText,
                                  .remote_frames = true,
                                  .xl = true};

}  // namespace mlcca::core::profiles
