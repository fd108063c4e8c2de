// SPDX-License-Identifier: BSD-2-Clause
// Prints the events of channels, one in a line: when it came, from where, channel, octets; and what
// happens to the channels, to the standard error.
//   g++ -std=c++17 logger.cc $(pkg-config --cflags --libs mlcca) -o logger
//   ./logger /run/mlcca/control.sock stop video
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "mlcca/client/client.hpp"

namespace {

using mlcca::client::Event;
using mlcca::client::Exception;
using mlcca::client::SubscriberChannel;

constexpr std::size_t kMostOctets = 16;  // of an event that are printed

void print(const std::string& channel, const Event& event) {
  const std::chrono::duration<double> since_1970 = event.received.time_since_epoch();
  std::printf("%.6f %s %s ", since_1970.count(), *event.network == '\0' ? "here" : event.network,
              channel.c_str());
  for (std::size_t i = 0; i < std::min(event.size, kMostOctets); ++i)
    std::printf("%02x", event.data[i]);
  std::printf("%s\n", event.size > kMostOctets ? "…" : "");
  std::fflush(stdout);
}

std::unique_ptr<SubscriberChannel> follow(mlcca::client::Client& client, const std::string& name) {
  auto channel = std::make_unique<SubscriberChannel>(client, name);
  channel->on_event([name](const Event& event) { print(name, event); });
  channel->on_exception([name](const Exception& exception) {
    std::cerr << name << ": " << mlcca::client::name_of(exception.cause) << ": " << exception.text
              << std::endl;
  });
  const auto answer = channel->subscribe();
  std::cerr << name << ": " << mlcca::client::name_of(answer->state) << ", " << answer->reason
            << std::endl;
  return channel;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::cerr << "usage: logger SOCKET CHANNEL…" << std::endl;
    return 2;
  }
  mlcca::client::Options options;
  options.socket = argv[1];
  mlcca::client::Client client(options);
  std::vector<std::unique_ptr<SubscriberChannel>> channels;
  for (int i = 2; i < argc; ++i) channels.push_back(follow(client, argv[i]));
  for (;;) client.wait(std::chrono::milliseconds(-1));
}
