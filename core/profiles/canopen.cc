// SPDX-License-Identifier: BSD-2-Clause
// CANopen: the 11-bit COB-ID identifies the subject.
#include "base/number.hpp"
#include "core/profiles/definition.hpp"

namespace mlcca::core::profiles {
namespace {

// CiA 301 v4.2, table 39.
constexpr std::uint32_t kNodeId = 0x7f;
constexpr std::array kNmt = {standard(0x000, 0, 2)};
constexpr std::array kSync = {standard(0x080, 0, 1)};
constexpr std::array kEmergency = {standard(0x080, kNodeId, 8)};
constexpr std::array kTime = {standard(0x100, 0, 6)};
constexpr std::array kErrorControl = {standard(0x700, kNodeId, 1)};
constexpr std::array kControl = {
    ControlKind{.name = "nmt", .frames = kNmt, .rate = 50, .burst = 10},
    ControlKind{.name = "sync", .frames = kSync, .rate = 1000, .burst = 2},
    ControlKind{.name = "emergency", .frames = kEmergency, .rate = 200, .burst = 127},
    ControlKind{.name = "time", .frames = kTime, .rate = 10, .burst = 2},
    ControlKind{.name = "error-control", .frames = kErrorControl, .rate = 1500, .burst = 127}};

std::vector<std::string> problems(const Binding& b) {
  if (b.id <= canopen.last) return {};
  return {"COBID " + hexadecimal(b.id) + " is too large: up to 0x7ff"};
}

}  // namespace

constinit const ProfileTraits canopen{
    .element = "a COBID",
    .form = IdentifierForm::standard,
    .last = kStandardBits,
    .problems = problems,
    .identity = plain,
    .overlap = overlap,
    .number_text = {.digits = 3, .stem = "cob-", .name_digits = 3},
    .has_heart_beats = true,
    .has_services = true,
    .remote_frames = true,
    .control = kControl};

}  // namespace mlcca::core::profiles
