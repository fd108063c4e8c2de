// SPDX-License-Identifier: BSD-2-Clause
// The snippets for Make and CMake, used by projects as a user would write them.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/support/source_tree.hpp"
#include "tests/tools/design/describe/program.hpp"
#include "tests/tools/design/generate/systems.hpp"

namespace mlcca::test {
namespace {

namespace fs = std::filesystem;

std::string mlccactl() {
  return fs::read_symlink("/proc/self/exe").parent_path().parent_path() / "mlccactl";
}

std::string with_wheels(std::string text) {
  return text.replace(text.find("<Component name=\"motors\""), 24, "<Component name=\"wheels\"");
}

TEST(GenerateBuildTest, TheExampleMakefileBuildsAndFollowsTheDescription) {
  const Folder folder;
  const auto system = folder.write("system.xml", robot());
  const std::vector<std::string> make = {
      "make",
      "-C",
      folder.path(""),
      "-f",
      mlcca::testing::source_tree().string() + "examples/generated/Makefile",
      "MLCCA_SYSTEM=" + system,
      "MLCCACTL=" + mlccactl(),
      "MLCCA_INCLUDE=" + mlcca::testing::source_tree().string() + "include"};
  auto ran = run_program(make);
  ASSERT_EQ(ran.status, 0) << ran.out;
  EXPECT_TRUE(fs::exists(folder.path("generated/motors_callbacks.o"))) << ran.out;

  ran = run_program(make);
  EXPECT_EQ(ran.status, 0);
  EXPECT_FALSE(ran.out.contains("generate")) << ran.out;

  folder.write("system.xml", with_wheels(robot()));
  // Newer by a file system's coarsest clock.
  fs::last_write_time(system, fs::file_time_type::clock::now() + std::chrono::seconds(2));
  ran = run_program(make);
  EXPECT_EQ(ran.status, 0) << ran.out;
  EXPECT_TRUE(fs::exists(folder.path("generated/wheels_callbacks.o"))) << ran.out;
}

TEST(GenerateBuildTest, CMakeBuildsAndFollowsTheDescription) {
  const Folder folder;
  const auto system = folder.write("system.xml", robot());
  ASSERT_EQ(run({"generate", system, "--out", folder.path("generated")}).status, 0);
  folder.write("CMakeLists.txt",
               "cmake_minimum_required(VERSION 3.19)\nproject(node CXX)\n"
               "set(CMAKE_CXX_STANDARD 14)\n"
               "set(MLCCA_SYSTEM ${CMAKE_CURRENT_LIST_DIR}/system.xml)\n"
               "include(generated/mlcca_generated.cmake)\n"
               "add_library(node STATIC ${MLCCA_GENERATED_SOURCES})\n"
               "target_include_directories(node PRIVATE ${MLCCA_GENERATED_INCLUDE_DIRS} " +
                   mlcca::testing::source_tree().string() + "include)\n");
  auto ran = run_program(
      {"cmake", "-S", folder.path(""), "-B", folder.path("build"), "-DMLCCACTL=" + mlccactl()});
  ASSERT_EQ(ran.status, 0) << ran.out;
  folder.write("system.xml", with_wheels(robot()));
  fs::last_write_time(system, fs::file_time_type::clock::now() + std::chrono::seconds(2));
  ran = run_program({"cmake", "--build", folder.path("build")});
  EXPECT_EQ(ran.status, 0) << ran.out;
  EXPECT_TRUE(ran.out.contains("wheels_callbacks.cpp")) << ran.out;
}

}  // namespace
}  // namespace mlcca::test
