// SPDX-License-Identifier: BSD-2-Clause
// A program for tests: speak SOCKET publisher CHANNEL publishes each line of its standard input;
// speak SOCKET subscriber CHANNEL prints each event behind the network that it came from.
#include <poll.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <iostream>
#include <string>

#include "mlcca/client/client.hpp"

namespace {

using namespace mlcca::client;  // NOLINT(google-build-using-namespace): it is its test

void say(const std::string& text) { std::cout << text << std::endl; }

int publish(Client& client, const std::string& channel) {
  PublisherChannel publisher(client, channel);
  publisher.on_exception(
      [](const Exception& e) { say(std::string("exception ") + name_of(e.cause)); });
  say(std::string("announced ") + name_of(publisher.announce()->state));
  std::string text;
  for (;;) {
    std::array<pollfd, 2> waits{pollfd{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0},
                                pollfd{.fd = client.fd(), .events = POLLIN, .revents = 0}};
    ::poll(waits.data(), waits.size(), -1);
    if (waits[1].revents != 0) client.process();
    if (waits[0].revents == 0) continue;
    char octet = 0;
    if (::read(STDIN_FILENO, &octet, 1) != 1) return 0;
    if (octet != '\n') {
      text += octet;
      continue;
    }
    say(name_of(publisher.publish(text)));
    text.clear();
  }
}

[[noreturn]] void subscribe(Client& client, const std::string& channel) {
  SubscriberChannel subscriber(client, channel);
  subscriber.on_event([](const Event& e) {
    const std::string network(e.network);
    say((network.empty() ? "here" : network) + " " +
        std::string(reinterpret_cast<const char*>(e.data), e.size));  // NOLINT(*-reinterpret-cast)
  });
  say(std::string("subscribed ") + name_of(subscriber.subscribe()->state));
  for (;;) client.wait(std::chrono::hours(1));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "speak SOCKET publisher|subscriber CHANNEL\n";
    return 2;
  }
  Options options;
  options.socket = argv[1];
  Client client(options);
  if (std::string(argv[2]) == "publisher") return publish(client, argv[3]);
  subscribe(client, argv[3]);
}
