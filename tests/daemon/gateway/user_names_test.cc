// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/user_names.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>

namespace mlcca {
namespace {

class UserNamesTest : public ::testing::Test {
 protected:
  UserNamesTest() {
    std::array<char, 32> name{"/tmp/mlcca-users-XXXXXX"};
    folder_ = ::mkdtemp(name.data());
    path_ = folder_ + "/passwd";
  }
  ~UserNamesTest() override { std::filesystem::remove_all(folder_); }
  UserNamesTest(const UserNamesTest&) = delete;
  UserNamesTest& operator=(const UserNamesTest&) = delete;
  UserNamesTest(UserNamesTest&&) = delete;
  UserNamesTest& operator=(UserNamesTest&&) = delete;

  /// As usermod does it: a new file takes the place of the old one.
  void write(const std::string& text) const {
    std::ofstream(path_ + "+") << text;
    std::filesystem::rename(path_ + "+", path_);
  }
  std::string folder_;
  std::string path_;
};

TEST_F(UserNamesTest, AreThoseOfTheFile) {
  write("root:x:0:0::/root:/bin/sh\nalice:x:1000:1000::/:/bin/sh\ntwin:x:1000:1::/:/bin/sh\n");
  UserNames names(path_);
  EXPECT_EQ(names.of(0), "root");
  EXPECT_EQ(names.of(1000), "alice") << "the first entry counts";
  EXPECT_EQ(names.of(1001), "");
}

TEST_F(UserNamesTest, FollowTheFile) {
  UserNames names(path_);
  EXPECT_EQ(names.of(7), "") << "there is none";
  write("alice:x:7:7::/:/bin/sh\n");
  EXPECT_EQ(names.of(7), "alice");
  write("bob:x:7:7::/:/bin/sh\n");
  EXPECT_EQ(names.of(7), "bob");
  write("");
  EXPECT_EQ(names.of(7), "");
}

TEST_F(UserNamesTest, DoNotComeFromAFileThatIsTooLongOrNoFile) {
  const std::string entry = "alice:x:7:7::/:/bin/sh\n";
  const auto room = static_cast<std::size_t>(UserNames::kMostBytes) - entry.size();
  write(entry + std::string(room - 1, '#') + "\n");
  EXPECT_EQ(UserNames(path_).of(7), "alice");
  write(entry + std::string(room, '#') + "\n");
  EXPECT_EQ(UserNames(path_).of(7), "");
  std::filesystem::remove(path_);
  ASSERT_EQ(::mkfifo(path_.c_str(), S_IRUSR | S_IWUSR), 0);
  EXPECT_EQ(UserNames(path_).of(7), "") << "and does not wait for a writer";
}

}  // namespace
}  // namespace mlcca
