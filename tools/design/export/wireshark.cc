// SPDX-License-Identifier: BSD-2-Clause
// Generates a dissector in Lua: a table with the content of the description, and a constant
// program.
#include <fmt/format.h>

#include <string>
#include <string_view>

#include "core/model/words.hpp"
#include "tools/design/export/admitted.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::string_view kProgram =
#include "tools/design/export/wireshark.lua.inc"
    ;

/// A string literal of Lua with any content.
std::string lua_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      out += fmt::format("\\{}", c);
    else if (byte < ' ' || byte == 0x7f)
      out += fmt::format("\\{:03}", byte);
    else
      out += c;
  }
  return out + '"';
}

}  // namespace

Exported export_wireshark(const Admitted& admitted) {
  const auto& system = admitted.system();
  Exported out;
  out.text = fmt::format("-- Names of {}, made by mlccactl export.\n", system.name);
  out.text += "local subjects = {\n";
  for (const auto& channel : system.channels)
    out.text += fmt::format("  [\"{:016x}\"] = {},\n", channel.subject, lua_text(channel.name));
  out.text += "}\nlocal can_frames = {\n";
  for (std::size_t n = 0; n < system.networks.size(); ++n) {
    const auto& network = system.networks[n];
    if (network.kind != core::NetworkKind::can) continue;
    for (const auto& frames : frames_on(admitted, n, out.lacks))
      out.text += fmt::format(
          "  {{network = {}, profile = {}, id = 0x{:x}, mask = 0x{:x}, extended = {}, "
          "channel = {}, sender = {}}},\n",
          lua_text(network.name), lua_text(core::words::kProfiles.of(network.profile)),
          frames.identity.id & core::kExtendedBits, frames.identity.mask & core::kExtendedBits,
          (frames.identity.id & core::kExtendedFlag) != 0,
          lua_text(system.channels[frames.channel].name), lua_text(frames.sender));
  }
  out.text += "}\n";
  out.text += kProgram;
  return out;
}

}  // namespace mlcca::tools::design
