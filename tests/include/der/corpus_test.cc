// SPDX-License-Identifier: BSD-2-Clause
// Every file of tests/corpus/der is a case: good-* is understood, bad-* is refused.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "mlcca/der.hpp"
#include "tests/include/der/octets.hpp"

namespace mlcca::testing {
namespace {

TEST(CorpusTest, GoodIsUnderstoodAndBadIsRefused) {
  int good = 0;
  int bad = 0;
  for (const auto& entry : std::filesystem::directory_iterator("tests/corpus/der")) {
    std::ifstream file(entry.path(), std::ios::binary);
    const Octets octets{std::istreambuf_iterator<char>(file), {}};
    const bool is_good = entry.path().filename().string().starts_with("good-");
    der::Decoded decoded;
    const der::Status status = der::decode(octets.data(), octets.size(), &decoded);
    EXPECT_EQ(status.ok(), is_good) << entry.path() << ": " << der::to_text(status.error);
    ++(is_good ? good : bad);
  }
  EXPECT_GT(good, 0);
  EXPECT_GT(bad, 0);
}

}  // namespace
}  // namespace mlcca::testing
