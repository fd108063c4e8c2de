// SPDX-License-Identifier: BSD-2-Clause
#include "base/sha256.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <string>

namespace mlcca {
namespace {

std::string hex(Sha256& hash) {
  std::string out;
  for (const std::uint8_t octet : hash.digest()) {
    std::array<char, 3> two{};
    std::snprintf(two.data(), two.size(), "%02x", octet);
    out += two.data();
  }
  return out;
}
std::string hash_of(std::string_view text) {
  Sha256 hash;
  hash.add(text);
  return hex(hash);
}

// FIPS 180-4, examples of NIST; those around a block are of sha256sum.
TEST(Sha256Test, IsAsTheStandardSays) {
  EXPECT_EQ(hash_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(hash_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(hash_of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(hash_of(std::string(1'000'000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256Test, DoesNotDependOnHowItIsCut) {
  std::string text;
  for (int n = 0; n < 400; ++n) text += static_cast<char>(n);
  for (std::size_t size = 0; size < text.size(); ++size) {
    Sha256 in_parts;
    const std::string_view whole = std::string_view(text).substr(0, size);
    for (std::size_t at = 0; at < size; at += 7) in_parts.add(whole.substr(at, 7));
    EXPECT_EQ(hex(in_parts), hash_of(whole)) << size;
  }
}

}  // namespace
}  // namespace mlcca
