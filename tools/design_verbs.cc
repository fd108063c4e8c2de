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

}  // namespace

bool is_design_time(std::span<char*> arguments) {
  const auto word =
      std::ranges::find_if(arguments.subspan(std::min<std::size_t>(1, arguments.size())),
                           [](const char* a) { return *a != '-'; });
  return word != arguments.end() && std::ranges::any_of(kDesignVerbs, [&](const DesignVerb& v) {
           return std::strcmp(v.name, *word) == 0;
         });
}

Exit become_design(char** arguments) {
  const auto folder = own_folder();
  for (const char* place : {"mlcca-design", "../libexec/mlcca/mlcca-design"})
    ::execv((folder + place).c_str(), arguments);
  fmt::print(stderr,
             "mlccactl: {}mlcca-design: {}\nThe verbs of design time are a program of their own: "
             "install it, or put it beside mlccactl.\n",
             folder, ::strerror(errno));
  return Exit::world;
}

}  // namespace mlcca::tools
