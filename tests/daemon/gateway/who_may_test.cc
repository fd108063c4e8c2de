// SPDX-License-Identifier: BSD-2-Clause
// Every request of the control protocol from a user who may change nothing.
#include "tests/daemon/gateway/who_may.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <utility>
#include <variant>

#include "daemon/gateway/requests/table.hpp"
#include "tests/daemon/gateway/bench.hpp"

namespace mlcca::test {
namespace {

using Body = control::RequestBody;

bool is_forbidden(const serve::Answer& answer) {
  const auto* error = std::get_if<control::Error>(&answer.reply.body);
  return error != nullptr && error->kind == control::ErrorKind::forbidden;
}

class EachRequest : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_FALSE(bench_.start()); }

  template <std::size_t I>
  void check() {
    const std::variant_alternative_t<I, Body::Variant> request{};
    const Who who = who_may(request);
    const control::Request whole{.id = 1, .body = request};
    const std::string where = "request " + std::to_string(I) + " of the protocol";
    EXPECT_EQ(requests::privilege_of(whole), privilege_of(who)) << where;
    bench_.events.clear();
    const bool forbidden = is_forbidden(bench_.ask(request, outsider()));
    EXPECT_EQ(forbidden, who != Who::anyone) << where;
    EXPECT_TRUE(bench_.events.empty()) << where << " has changed something";
  }
  template <std::size_t... I>
  void check_all(std::index_sequence<I...> /*all*/) {
    (check<I>(), ...);
  }
  static requests::Privilege privilege_of(Who who) {
    switch (who) {
      case Who::anyone:
        return requests::Privilege::anyone;
      case Who::program:
        return requests::Privilege::program;
      case Who::member:
        break;
    }
    return requests::Privilege::member;
  }

  Bench bench_{small_system()};
};

TEST_F(EachRequest, IsRefusedToWhomItIsNotFor) {
  check_all(std::make_index_sequence<std::variant_size_v<Body::Variant>>());
  EXPECT_FALSE(bench_.reading().busy());
  EXPECT_EQ(bench_.kernel.mode, gates::Mode::enforce);
}

}  // namespace
}  // namespace mlcca::test
