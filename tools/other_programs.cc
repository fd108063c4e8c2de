// SPDX-License-Identifier: BSD-2-Clause
#include "tools/other_programs.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <string_view>

#include "base/standard_streams.hpp"

namespace mlcca::tools {
namespace {

/// The folder of this program with its final slash; empty if it is unknown.
std::string own_folder() {
  std::array<char, 4096> path{};
  const auto size = ::readlink("/proc/self/exe", path.data(), path.size());
  if (size <= 0) return {};
  const std::string_view whole(path.data(), static_cast<std::size_t>(size));
  return std::string(whole.substr(0, whole.rfind('/') + 1));
}

/// The first word that is neither an option nor the value of one.
std::string_view verb_of(std::span<char*> arguments) {
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    const std::string_view word = arguments[i];
    if (word == "--socket" || word == "--timeout")
      ++i;
    else if (!word.starts_with('-'))
      return word;
  }
  return {};
}

bool is_read_back(std::string_view verb, std::span<char*> arguments) {
  return verb == "gate" && std::ranges::any_of(arguments, [](const char* a) {
           return std::strcmp(a, "--verify") == 0;
         });
}

}  // namespace

const Program* program_for(std::span<char*> arguments) {
  const auto verb = verb_of(arguments);
  if (is_read_back(verb, arguments)) return &kReadback;
  const auto* const other = std::ranges::find(kOtherVerbs, verb, &OtherVerb::name);
  return other == kOtherVerbs.end() ? nullptr : other->program;
}

Exit become(const Program& program, char** arguments) {
  const auto folder = own_folder();
  for (const char* place : {"", "../libexec/mlcca/"})
    ::execv((folder + place + program.name).c_str(), arguments);
  to_stderr(fmt::format("mlccactl: {}{}: {}\n{}: install it, or put it beside mlccactl.\n", folder,
                        program.name, ::strerror(errno), program.what));
  return Exit::world;
}

}  // namespace mlcca::tools
