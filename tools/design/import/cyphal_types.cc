// SPDX-License-Identifier: BSD-2-Clause
// Sizes of regulated data types, as pydsdl computes them from
// github.com/OpenCyphal/public_regulated_data_types at f9f67906cc0c: the longest message of exactly
// that version. An extent would include room for later versions.
#include <algorithm>
#include <array>

#include "tools/design/import/cyphal.hpp"

namespace mlcca::tools::design {
namespace {

struct TypeSize {
  std::string_view name;
  Value bytes;
};

constexpr auto kWhole = std::to_array<TypeSize>({
    {"uavcan.node.Heartbeat.1.0", 7},
    {"uavcan.primitive.String.1.0", 258},
    {"uavcan.primitive.Unstructured.1.0", 258},
    {"uavcan.time.Synchronization.1.0", 7},
    {"reg.udral.physics.dynamics.rotation.Planar.0.1", 16},
    {"reg.udral.physics.dynamics.rotation.PlanarTs.0.1", 23},
    {"reg.udral.physics.dynamics.translation.Linear.0.1", 16},
    {"reg.udral.physics.dynamics.translation.LinearTs.0.1", 23},
    {"reg.udral.physics.electricity.Power.0.1", 8},
    {"reg.udral.physics.electricity.PowerTs.0.1", 15},
    {"reg.udral.physics.electricity.Source.0.1", 16},
    {"reg.udral.physics.electricity.SourceTs.0.1", 23},
    {"reg.udral.physics.kinematics.rotation.Planar.0.1", 12},
    {"reg.udral.physics.kinematics.rotation.PlanarTs.0.1", 19},
    {"reg.udral.physics.kinematics.translation.Linear.0.1", 12},
    {"reg.udral.physics.kinematics.translation.LinearTs.0.1", 19},
    {"reg.udral.physics.kinematics.translation.LinearVarTs.0.1", 25},
    {"reg.udral.physics.thermodynamics.PressureTempVarTs.0.1", 21},
    {"reg.udral.service.actuator.common.Feedback.0.1", 3},
    {"reg.udral.service.actuator.common.Status.0.1", 14},
    {"reg.udral.service.actuator.common.sp.Scalar.0.1", 2},
    {"reg.udral.service.actuator.common.sp.Vector2.0.1", 4},
    {"reg.udral.service.actuator.common.sp.Vector3.0.1", 6},
    {"reg.udral.service.actuator.common.sp.Vector4.0.1", 8},
    {"reg.udral.service.actuator.common.sp.Vector6.0.1", 12},
    {"reg.udral.service.actuator.common.sp.Vector8.0.1", 16},
    {"reg.udral.service.actuator.common.sp.Vector31.0.1", 62},
    {"reg.udral.service.battery.Status.0.2", 526},
    {"reg.udral.service.common.Heartbeat.0.1", 2},
    {"reg.udral.service.common.Readiness.0.1", 1},
    {"reg.udral.service.sensor.Status.0.1", 12},
});

/// Types of uavcan.primitive.scalar, version 1.0.
constexpr auto kScalars = std::to_array<TypeSize>({{"Bit", 1},
                                                   {"Integer8", 1},
                                                   {"Integer16", 2},
                                                   {"Integer32", 4},
                                                   {"Integer64", 8},
                                                   {"Natural8", 1},
                                                   {"Natural16", 2},
                                                   {"Natural32", 4},
                                                   {"Natural64", 8},
                                                   {"Real16", 2},
                                                   {"Real32", 4},
                                                   {"Real64", 8}});

/// Types of uavcan.si for any quantity, versions 1.0 and 1.1.
constexpr auto kQuantities = std::to_array<TypeSize>(
    {{"Scalar", 4}, {"WideScalar", 8}, {"Vector3", 12}, {"WideVector3", 24}, {"Quaternion", 16}});
constexpr Value kTimestamp = 7;  // precedes a sample

template <class Rows>
std::optional<Value> size_in(const Rows& rows, std::string_view name) {
  const auto* const found = std::ranges::find(rows, name, &TypeSize::name);
  if (found == rows.end()) return std::nullopt;
  return found->bytes;
}

/// If the text begins (or ends) with that, removes it and returns true.
bool take_front(std::string_view& text, std::string_view front) {
  if (!text.starts_with(front)) return false;
  text.remove_prefix(front.size());
  return true;
}
bool take_back(std::string_view& text, std::string_view back) {
  if (!text.ends_with(back)) return false;
  text.remove_suffix(back.size());
  return true;
}

}  // namespace

std::optional<Value> cyphal_size(std::string_view type) {
  if (const auto whole = size_in(kWhole, type)) return whole;
  if (take_front(type, "uavcan.primitive.scalar."))
    return take_back(type, ".1.0") ? size_in(kScalars, type) : std::nullopt;
  const bool sample = take_front(type, "uavcan.si.sample.");
  if (!sample && !take_front(type, "uavcan.si.unit.")) return std::nullopt;
  if (!take_back(type, ".1.0") && !take_back(type, ".1.1")) return std::nullopt;
  // such as "angular_velocity.Vector3"
  const auto dot = type.find('.');
  if (dot == std::string_view::npos || dot == 0) return std::nullopt;
  auto bytes = size_in(kQuantities, type.substr(dot + 1));
  if (bytes && sample) *bytes += kTimestamp;
  return bytes;
}

}  // namespace mlcca::tools::design
