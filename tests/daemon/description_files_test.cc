// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/description_files.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "core/cluster/keys.hpp"
#include "description/bundle.hpp"

namespace mlcca {
namespace {

namespace fs = std::filesystem;

class DescriptionsOnDisk : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = testing::TempDir() + "texts-XXXXXX";
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder = pattern;
    files.emplace(folder.string());
  }
  void TearDown() override { fs::remove_all(folder); }

  [[nodiscard]] fs::path path_of(const Sha256::Digest& of) const {
    return folder / ("description-" + core::cluster::hex_of(of));
  }
  static void write(const fs::path& path, const std::string& octets) {
    std::ofstream(path, std::ios::binary | std::ios::trunc) << octets;
  }
  [[nodiscard]] KeptText read() const { return files->reader()(digest); }

  const std::string text = description::bundle_of({{.name = "s.xml", .content = "<System/>"}});
  const Sha256::Digest digest = *description::digest_of(text);
  fs::path folder;
  std::optional<DescriptionFiles> files;
};

TEST_F(DescriptionsOnDisk, AreThereAsTheyWereKept) {
  EXPECT_FALSE(read().text);
  EXPECT_EQ(read().damage, "") << "it is not there";
  ASSERT_TRUE(files->keep(digest, text));
  EXPECT_EQ(read().text, text);
  struct stat status{};
  ASSERT_EQ(::stat(path_of(digest).c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
  ASSERT_TRUE(files->keep(digest, text));
}

TEST_F(DescriptionsOnDisk, AreKeptUnderTheirOwnDigestAlone) {
  EXPECT_FALSE(files->keep(digest, description::bundle_of({{.name = "s", .content = "<S/>"}})));
  EXPECT_FALSE(files->keep(digest, "no such text"));
  EXPECT_TRUE(fs::is_empty(folder));
}

TEST_F(DescriptionsOnDisk, AreNotUsedWhereTheyAreDamagedAndCanBeKeptAgain) {
  std::string other = text;
  other[other.size() - 4] = '~';
  for (const std::string& damaged : {other, text.substr(0, text.size() - 1), std::string(),
                                     std::string(description::kMaxBundle + 1, 'x')}) {
    write(path_of(digest), damaged);
    EXPECT_FALSE(read().text);
    EXPECT_NE(read().damage, "") << damaged.size();
    ASSERT_TRUE(files->keep(digest, text));
    EXPECT_EQ(read().text, text);
  }
}

TEST_F(DescriptionsOnDisk, AreNoLinksAndNoFifos) {
  write(folder / "elsewhere", text);
  fs::create_symlink(folder / "elsewhere", path_of(digest));
  EXPECT_FALSE(read().text);
  EXPECT_NE(read().damage, "");
  ASSERT_TRUE(files->keep(digest, text));
  EXPECT_FALSE(fs::is_symlink(path_of(digest)));
  fs::remove(path_of(digest));
  ASSERT_EQ(::mkfifo(path_of(digest).c_str(), 0600), 0);
  EXPECT_FALSE(read().text);
  ASSERT_TRUE(files->keep(digest, text));
  EXPECT_EQ(read().text, text);
}

TEST_F(DescriptionsOnDisk, AreReadByWhoeverStillHasAReader) {
  ASSERT_TRUE(files->keep(digest, text));
  const auto reader = files->reader();
  files.reset();
  EXPECT_EQ(reader(digest).text, text);
}

TEST_F(DescriptionsOnDisk, GoWhenNobodyNeedsThem) {
  ASSERT_TRUE(files->keep(digest, text));
  write(folder / "journal", "x");
  write(path_of(digest).string() + ".new", "x");
  files->keep_only({digest});
  EXPECT_TRUE(read().text);
  EXPECT_FALSE(fs::exists(path_of(digest).string() + ".new"));
  files->keep_only({});
  EXPECT_FALSE(read().text);
  EXPECT_TRUE(fs::exists(folder / "journal"));
}

}  // namespace
}  // namespace mlcca
