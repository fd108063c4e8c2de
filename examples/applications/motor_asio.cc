// SPDX-License-Identifier: BSD-2-Clause
// The motor of motor.cc in a loop of asio (Debian: libasio-dev). asio waits for the one descriptor
// of the Client, which is readable when there is work to do.
//   g++ -std=c++17 motor_asio.cc $(pkg-config --cflags --libs mlcca) -pthread -o motor_asio
#include <asio.hpp>
#include <chrono>
#include <iostream>

#include "mlcca/client/client.hpp"

namespace {

constexpr std::chrono::milliseconds kLongestSilence(3 * 50 + 5);

class Motor {
 public:
  explicit Motor(asio::io_context& loop) : timer_(loop) {}

  void beat() {
    set(true);
    timer_.expires_after(kLongestSilence);  // this cancels the former wait
    timer_.async_wait([this](const asio::error_code& cancelled) {
      if (!cancelled) set(false);
    });
  }

 private:
  void set(bool runs) {
    if (runs != runs_) std::cout << (runs ? "runs" : "stops") << std::endl;
    runs_ = runs;
  }
  asio::steady_timer timer_;
  bool runs_ = false;
};

void process_when_readable(asio::posix::stream_descriptor& descriptor,
                           mlcca::client::Client& client) {
  descriptor.async_wait(asio::posix::stream_descriptor::wait_read,
                        [&](const asio::error_code& error) {
                          if (error) return;
                          client.process();
                          process_when_readable(descriptor, client);
                        });
}

}  // namespace

int main(int argc, char** argv) {
  mlcca::client::Options options;
  if (argc > 1) options.socket = argv[1];
  mlcca::client::Client client(options);
  asio::io_context loop;
  Motor motor(loop);
  mlcca::client::SubscriberChannel stop(client, "stop");
  stop.on_event([&](const mlcca::client::Event&) { motor.beat(); });
  std::cout << "subscribed: " << mlcca::client::name_of(stop.subscribe()->state) << std::endl;
  asio::posix::stream_descriptor descriptor(loop, client.fd());
  process_when_readable(descriptor, client);
  loop.run();
  descriptor.release();  // the Client owns it
}
