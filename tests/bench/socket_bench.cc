// SPDX-License-Identifier: BSD-2-Clause
// A query over the control socket against a bare AF_UNIX round trip of the same sizes, in turns.
// usage: socket_bench SOCKET CHANNEL FROM TO
#include <fmt/core.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <vector>

#include "control/client.hpp"
#include "control/codec.hpp"

namespace {

using Clock = std::chrono::steady_clock;
constexpr int kRounds = 4000;

double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

bool transfer(int fd, std::vector<char>& bytes, bool out) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = out ? ::send(fd, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL)
                          : ::recv(fd, bytes.data() + done, bytes.size() - done, 0);
    if (n <= 0) return false;
    done += static_cast<std::size_t>(n);
  }
  return true;
}

/// The other process of the bare round trip: reads a request, writes an answer, knows nothing.
[[noreturn]] void echo(int fd, std::size_t request, std::size_t reply) {
  std::vector<char> in(request);
  std::vector<char> out(reply);
  while (transfer(fd, in, false) && transfer(fd, out, true)) {
  }
  std::_Exit(0);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  auto client = mlcca::control::Client::connect(argv[1]);
  if (!client) {
    fmt::print(stderr, "{}\n", client.error().text);
    return 3;
  }
  mlcca::control::Query query;
  query.channel = argv[2];
  query.from = argv[3];
  query.to = argv[4];
  query.subscriber = "bench";
  const mlcca::control::Request request{1, query};
  auto reply = client->call(request);
  const auto* channels = reply ? std::get_if<mlcca::control::Channels>(&reply->body) : nullptr;
  if (channels == nullptr || channels->channels.empty() || !channels->channels[0].granted) {
    fmt::print(stderr, "the query was not granted: the bench measures a grant\n");
    return 1;
  }
  std::vector<char> out(mlcca::control::encode(request).size());
  std::vector<char> in(mlcca::control::encode(*reply).size());
  int pair[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM, 0, pair) < 0) return 3;
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(pair[0]);
    echo(pair[1], out.size(), in.size());
  }
  ::close(pair[1]);
  std::vector<double> bare;
  std::vector<double> ours;
  for (int i = 0; i < kRounds; ++i) {
    const auto a = Clock::now();
    if (!transfer(pair[0], out, true) || !transfer(pair[0], in, false)) return 3;
    const auto b = Clock::now();
    if (!client->call(request)) return 3;
    const auto c = Clock::now();
    bare.push_back(std::chrono::duration<double, std::micro>(b - a).count());
    ours.push_back(std::chrono::duration<double, std::micro>(c - b).count());
  }
  ::close(pair[0]);
  ::waitpid(child, nullptr, 0);
  fmt::print(
      "query over the socket            {:8.1f} us   bare round trip {:8.1f} us   ratio {:.2f}\n",
      median(ours), median(bare), median(ours) / median(bare));
  return 0;
}
