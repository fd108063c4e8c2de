// SPDX-License-Identifier: BSD-2-Clause
// gate.conf and conf.d: what is named, what is a mistake, and where.
#include "daemon/interface_files.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace mlcca {
namespace {

using Lines = std::vector<std::string>;

class InterfaceFilesTest : public testing::Test {
 protected:
  InterfaceFilesTest() {
    std::array<char, 32> name{"/tmp/interface-files-XXXXXX"};
    folder_ = ::mkdtemp(name.data());
    std::filesystem::create_directory(folder_ + "/conf.d");
  }
  ~InterfaceFilesTest() override { std::filesystem::remove_all(folder_); }

  void write(const std::string& file, const std::string& text) const {
    std::ofstream(folder_ + "/" + file) << text;
  }
  [[nodiscard]] Lines places() const {
    Lines all;
    for (const auto& [name, place] : read_interface_files(folder_).named)
      all.push_back(name + " " + place.substr(folder_.size() + 1));
    return all;
  }
  [[nodiscard]] Lines mistakes() const {
    Lines all;
    for (const std::string& one : read_interface_files(folder_).mistakes)
      all.push_back(one.substr(folder_.size() + 1));
    return all;
  }

  std::string folder_;
};

TEST_F(InterfaceFilesTest, AddUpInTheOrderOfTheirNames) {
  write("gate.conf", "# at boot\nMLCCA_INTERFACES=can0 can1\n");
  write("conf.d/20-rear.conf", "MLCCA_INTERFACES=can4\n");
  write("conf.d/10-front.conf",
        "\n; two\nMLCCA_INTERFACES=\"can2\tcan3\"\r\nMLCCA_INTERFACES=can1\n");
  write("conf.d/30-radio.conf", "  MLCCA_INTERFACES = 'wpan0'");
  EXPECT_EQ(places(), (Lines{"can0 gate.conf:2", "can1 gate.conf:2", "can2 conf.d/10-front.conf:3",
                             "can3 conf.d/10-front.conf:3", "can4 conf.d/20-rear.conf:1",
                             "wpan0 conf.d/30-radio.conf:1"}));
  EXPECT_EQ(mistakes(), Lines());
  EXPECT_TRUE(read_interface_files(folder_).names("can4"));
  EXPECT_FALSE(read_interface_files(folder_).names("can"));
}

TEST_F(InterfaceFilesTest, AnEmptyListTakesNothingAway) {
  write("gate.conf", "MLCCA_INTERFACES=can0\n");
  write("conf.d/99.conf", "MLCCA_INTERFACES=\n");
  EXPECT_EQ(places(), (Lines{"can0 gate.conf:1"}));
  EXPECT_EQ(mistakes(), Lines());
}

TEST_F(InterfaceFilesTest, WhatIsNotThereNamesNothing) {
  std::filesystem::remove(folder_ + "/conf.d");
  EXPECT_EQ(places(), Lines());
  EXPECT_EQ(mistakes(), Lines());
  EXPECT_EQ(read_interface_files(folder_ + "/missing").mistakes, Lines());
}

TEST_F(InterfaceFilesTest, FilesOfOtherNamesAreNotRead) {
  for (const char* name : {"README", "10.conf.dpkg-dist", "10.conf~", ".hidden.conf"})
    write(std::string("conf.d/") + name, "MLCCA_INTERFACES=can7\n");
  EXPECT_EQ(places(), Lines());
  EXPECT_EQ(mistakes(), Lines());
}

TEST_F(InterfaceFilesTest, AMistakeSaysFileAndLineAndTheOthersAreRead) {
  write("conf.d/10.conf", "MLCCA_INTERFACE=can0\nMLCCA_INTERFACES=can1 can2,can3 can4\ncan5\n");
  write("conf.d/20.conf", "MLCCA_INTERFACES=can6 interface-too-long\nMLCCA_INTERFACES=\"can7\n");
  EXPECT_EQ(places(),
            (Lines{"can1 conf.d/10.conf:2", "can4 conf.d/10.conf:2", "can6 conf.d/20.conf:1"}));
  EXPECT_EQ(
      mistakes(),
      (Lines{
          "conf.d/10.conf:1: 'MLCCA_INTERFACE' is no setting: MLCCA_INTERFACES is",
          "conf.d/10.conf:2: 'can2,can3' is no name of an interface (names stand between spaces)",
          "conf.d/10.conf:3: 'can5' is no setting: MLCCA_INTERFACES=NAME… is",
          "conf.d/20.conf:1: 'interface-too-long' is no name of an interface: it has at most 15 "
          "characters",
          "conf.d/20.conf:2: a quotation mark has no other one"}));
}

TEST_F(InterfaceFilesTest, DotsAndWhatIsNoTextAreNoNames) {
  const std::string no_name = " is no name of an interface (names stand between spaces)";
  write("gate.conf",
        "MLCCA_INTERFACES=. ..\nMLCCA_INTERFACES=a" + std::string(1, '\0') + "b can\x1b[2J\n");
  EXPECT_EQ(places(), Lines());
  EXPECT_EQ(mistakes(),
            (Lines{"gate.conf:1: '.'" + no_name, "gate.conf:1: '..'" + no_name,
                   "gate.conf:2: 'a?b'" + no_name, "gate.conf:2: 'can?[2J'" + no_name}));
}

TEST_F(InterfaceFilesTest, WhatCannotBeReadIsAMistake) {
  std::filesystem::create_directory(folder_ + "/gate.conf");
  ASSERT_EQ(::mkfifo((folder_ + "/conf.d/10.conf").c_str(), 0600), 0);
  std::filesystem::create_symlink("/nowhere", folder_ + "/conf.d/20.conf");
  write("conf.d/30.conf", std::string(kInterfaceFileBytes, '#') + "\n");
  write("conf.d/40.conf", std::string(kInterfaceFileBytes - 1, '#') + "\n");
  EXPECT_EQ(mistakes(), (Lines{"gate.conf: is no file", "conf.d/10.conf: is no file",
                               "conf.d/20.conf: No such file or directory",
                               "conf.d/30.conf: has more than 65536 bytes"}));
}

TEST_F(InterfaceFilesTest, NoMoreIsReadThanTheLimits) {
  std::string many;
  for (std::size_t i = 0; i <= kNamedInterfaces; ++i)
    many += "MLCCA_INTERFACES=c" + std::to_string(i) + "\n";
  write("gate.conf", many);
  EXPECT_EQ(places().size(), kNamedInterfaces);
  EXPECT_EQ(mistakes(), (Lines{"gate.conf:1025: more than 1024 interfaces are named"}));
  write("gate.conf", "");
  for (std::size_t i = 0; i <= kInterfaceFiles; ++i)
    write("conf.d/" + std::to_string(1000 + i) + ".conf",
          "MLCCA_INTERFACES=d" + std::to_string(i) + "\n");
  EXPECT_EQ(places().size(), kInterfaceFiles);
  EXPECT_EQ(mistakes(),
            (Lines{"conf.d: has more than 256 files: 1256.conf and what follows is not read"}));
  for (int line = 0; line < 100; ++line) many += "nonsense\n";
  write("gate.conf", many);
  EXPECT_LE(mistakes().size(), 33U);
}

}  // namespace
}  // namespace mlcca
