// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/generate/build_files.hpp"

#include <fmt/format.h>

#include <string_view>

#include "tools/design/generate/header.hpp"

namespace mlcca::tools::design {
namespace {

std::string folder_of(const std::string& path) {
  const auto slash = path.rfind('/');
  return slash == std::string::npos ? std::string() : path.substr(0, slash + 1);
}

/// The included files in the folder of the description or below it.
std::vector<std::string> parts_of(const core::System& system) {
  std::vector<std::string> out;
  if (system.files.empty()) return out;
  const auto folder = folder_of(system.files.front());
  for (std::size_t i = 1; i < system.files.size(); ++i) {
    const auto& file = system.files[i];
    // Blanks, dollars and the like have a meaning in a makefile.
    const bool plain = file.find_first_of(" \t$#:;\"\\") == std::string::npos;
    const bool below = file.starts_with(folder) && (!folder.empty() || !file.starts_with('/'));
    if (plain && below) out.push_back(file.substr(folder.size()));
  }
  return out;
}

std::string joined(const std::vector<std::string>& names, std::string_view before,
                   std::string_view separator) {
  std::string out;
  for (const auto& name : names) out += fmt::format("{}{}{}", separator, before, name);
  return out;
}

}  // namespace

BuildFiles build_files(const core::System& system, const std::vector<Unit>& units,
                       const std::vector<std::string>& only) {
  std::vector<std::string> headers;
  std::vector<std::string> sources;
  headers.reserve(units.size());
  sources.reserve(units.size());
  for (const auto& unit : units) {
    headers.push_back(unit.stem + "_channels.hpp");
    sources.push_back(unit.stem + "_callbacks.cpp");
  }
  const auto parts = parts_of(system);
  const auto arguments = joined(only, "--component ", " ");
  BuildFiles out;
  out.make = fmt::format(
      "# {0}: change the description, not this file.\n"
      "# With MLCCA_SYSTEM, the path of the description, everything is generated again when it "
      "has\n"
      "# changed: include this file behind the first target.\n"
      "MLCCA_GENERATED_DIR := $(dir $(lastword $(MAKEFILE_LIST)))\n"
      "MLCCA_GENERATED_HEADERS :={1}\n"
      "MLCCA_GENERATED_SOURCES :={2}\n"
      "MLCCA_GENERATED_CPPFLAGS := -I$(MLCCA_GENERATED_DIR)\n"
      "ifdef MLCCA_SYSTEM\n"
      "MLCCACTL ?= mlccactl\n"
      "MLCCA_SYSTEM_PARTS :={3}\n"
      "$(MLCCA_GENERATED_DIR)mlcca_generated.mk: $(MLCCA_GENERATED_DIR)mlcca_generated.stamp ;\n"
      "$(MLCCA_GENERATED_DIR)mlcca_generated.stamp: $(MLCCA_SYSTEM) $(MLCCA_SYSTEM_PARTS)\n"
      "\t$(MLCCACTL) generate{4} --out $(MLCCA_GENERATED_DIR) $(MLCCA_SYSTEM)\n"
      "\ttouch $@\n"
      "$(MLCCA_SYSTEM_PARTS): ;\n"
      "endif\n",
      kMark, joined(headers, "$(MLCCA_GENERATED_DIR)", " \\\n\t"),
      joined(sources, "$(MLCCA_GENERATED_DIR)", " \\\n\t"),
      joined(parts, "$(dir $(MLCCA_SYSTEM))", " \\\n\t"), arguments);
  out.cmake = fmt::format(
      "# {0}: change the description, not this file.\n"
      "# With MLCCA_SYSTEM, the path of the description, everything is generated again when it "
      "has\n"
      "# changed.\n"
      "if(DEFINED MLCCA_SYSTEM AND NOT MLCCA_GENERATED_NOW)\n"
      "  if(NOT MLCCACTL)\n"
      "    find_program(MLCCACTL mlccactl REQUIRED)\n"
      "  endif()\n"
      "  execute_process(\n"
      "    COMMAND ${{MLCCACTL}} generate{4} --out ${{CMAKE_CURRENT_LIST_DIR}} ${{MLCCA_SYSTEM}}\n"
      "    COMMAND_ERROR_IS_FATAL ANY)\n"
      "  # This file may be another one now.\n"
      "  set(MLCCA_GENERATED_NOW TRUE)\n"
      "  include(${{CMAKE_CURRENT_LIST_FILE}})\n"
      "  unset(MLCCA_GENERATED_NOW)\n"
      "  return()\n"
      "endif()\n"
      "if(DEFINED MLCCA_SYSTEM)\n"
      "  get_filename_component(MLCCA_SYSTEM_DIR ${{MLCCA_SYSTEM}} DIRECTORY)\n"
      "  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS\n"
      "    ${{MLCCA_SYSTEM}}{3})\n"
      "endif()\n"
      "set(MLCCA_GENERATED_DIR ${{CMAKE_CURRENT_LIST_DIR}})\n"
      "set(MLCCA_GENERATED_HEADERS{1})\n"
      "set(MLCCA_GENERATED_SOURCES{2})\n"
      "set(MLCCA_GENERATED_INCLUDE_DIRS ${{CMAKE_CURRENT_LIST_DIR}})\n",
      kMark, joined(headers, "${CMAKE_CURRENT_LIST_DIR}/", "\n  "),
      joined(sources, "${CMAKE_CURRENT_LIST_DIR}/", "\n  "),
      joined(parts, "${MLCCA_SYSTEM_DIR}/", "\n    "), arguments);
  return out;
}

}  // namespace mlcca::tools::design
