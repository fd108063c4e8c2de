// SPDX-License-Identifier: BSD-2-Clause
#include "control/local_address.hpp"

#include <gtest/gtest.h>

namespace mlcca::control {
namespace {

TEST(LocalAddress, HasANameAndAKey) {
  const auto address = local_address_in("0a1b20123456789abcdef");
  ASSERT_TRUE(address);
  EXPECT_EQ(address->name, "0a1b2");
  EXPECT_EQ(address->key, 0x0123456789abcdefU);
  EXPECT_EQ(to_text(*address), "0a1b20123456789abcdef");
  EXPECT_EQ(to_text({.name = "fffff", .key = 0}), "fffff0000000000000000");
  EXPECT_EQ(local_address_in("fffffffffffffffffffff")->key, ~std::uint64_t{0});
}

TEST(LocalAddress, IsOfSoManyDigitsAndNothingElse) {
  for (const char* text :
       {"", "0a1b2", "0a1b20123456789abcde", "0a1b20123456789abcdef0", "0A1B20123456789abcdef",
        "0a1b20123456789ABCDEF", "0a1b2-123456789abcdef", "0a1b20x23456789abcdef",
        "0a1b2 123456789abcdef", "/run/0123456789abcdef", "0a1b20123456789abcdeg"})
    EXPECT_FALSE(local_address_in(text)) << text;
  EXPECT_FALSE(
      local_address_in(std::string_view("0a1b2\0"
                                        "123456789abcdef",
                                        21)));
}

}  // namespace
}  // namespace mlcca::control
