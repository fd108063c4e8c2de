// SPDX-License-Identifier: BSD-2-Clause
// A test with files of its own.
#pragma once
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace mlcca::description {

class WithFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string form = ::testing::TempDir() + "mlcca-description-XXXXXX";
    ASSERT_NE(mkdtemp(form.data()), nullptr);
    folder_ = form;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// The path of a file, which need not exist.
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }
  /// Writes it and returns its path.
  std::string file(const std::string& name, std::string_view content) {
    std::filesystem::create_directories(std::filesystem::path(path(name)).parent_path());
    std::ofstream(path(name), std::ios::binary) << content;
    return path(name);
  }

 private:
  std::string folder_;
};

}  // namespace mlcca::description
