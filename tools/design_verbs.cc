// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design_verbs.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <string_view>

namespace mlcca::tools {
namespace {

/// Folder of this program, with the slash; empty where it cannot be told.
std::string own_folder() {
  std::array<char, 4096> path{};
  const auto size = ::readlink("/proc/self/exe", path.data(), path.size());
  if (size <= 0) return {};
  const std::string_view whole(path.data(), static_cast<std::size_t>(size));
  return std::string(whole.substr(0, whole.rfind('/') + 1));
}

/// The first word that is no option.
std::string_view verb_of(std::span<char*> arguments) {
  const auto rest = arguments.subspan(std::min<std::size_t>(1, arguments.size()));
  const auto word = std::ranges::find_if(rest, [](const char* a) { return *a != '-'; });
  return word == rest.end() ? std::string_view() : *word;
}

Exit become(const std::string& program, const char* what, char** arguments) {
  const auto folder = own_folder();
  for (const char* place : {"", "../libexec/mlcca/"})
    ::execv((folder + place + program).c_str(), arguments);
  fmt::print(stderr,
             "mlccactl: {}{}: {}\n{}: install it, or put it beside "
             "mlccactl.\n",
             folder, program, ::strerror(errno), what);
  return Exit::world;
}

}  // namespace

bool is_design_time(std::span<char*> arguments) {
  return std::ranges::find(kDesignVerbs, verb_of(arguments), &DesignVerb::name) !=
         kDesignVerbs.end();
}

bool is_read_back(std::span<char*> arguments) {
  return verb_of(arguments) == "gate" && std::ranges::any_of(arguments, [](const char* a) {
           return std::strcmp(a, "--verify") == 0;
         });
}

Exit become_design(char** arguments) {
  return become("mlcca-design", "The verbs of design time are a program of their own", arguments);
}
Exit become_readback(char** arguments) {
  return become("mlcca-readback", "Reading back without the daemon is a program of its own",
                arguments);
}

}  // namespace mlcca::tools
