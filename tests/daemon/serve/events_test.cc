// SPDX-License-Identifier: BSD-2-Clause
// Which events whom reach, and under which name.
#include <string>
#include <vector>

#include "tests/daemon/serve/server_bench.hpp"

namespace mlcca::serve {
namespace {

/// A program that was made before there were kinds of their own goes on as it was.
TEST_F(ServerTest, ExactKindsAreForWhoAsksForThem) {
  answer_ = [](const Request& request, const Peer&) {
    return Answer{Reply{request.id, control::Done{}}};
  };
  const Fd exact = client();
  const Fd other = client();
  control::Buffer of_exact;
  control::Buffer of_other;
  ask(exact, 1, true, control::MonitorRequest{.exact_kinds = true});
  ask(other, 2, true, control::MonitorRequest{});
  ASSERT_EQ(replies(exact, of_exact).size() + replies(other, of_other).size(), 2U);
  for (const char* kind : {"revoked", "network-down", "removed", "withdrawn", "granted"})
    server_->publish({.unix_ns = 0, .kind = kind, .subject = 41});
  const auto kinds_of = [this](const Fd& socket, control::Buffer& buffer) {
    std::vector<std::string> kinds;
    for (const Reply& reply : replies(socket, buffer))
      kinds.push_back(std::get<control::Event>(reply.body).kind);
    return kinds;
  };
  EXPECT_EQ(
      kinds_of(exact, of_exact),
      (std::vector<std::string>{"revoked", "network-down", "removed", "withdrawn", "granted"}));
  EXPECT_EQ(
      kinds_of(other, of_other),
      (std::vector<std::string>{"withdrawn", "withdrawn", "withdrawn", "withdrawn", "granted"}));
}

}  // namespace
}  // namespace mlcca::serve
