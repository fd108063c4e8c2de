// SPDX-License-Identifier: BSD-2-Clause
// The motor of motor.cc in a loop of systemd (sd-event(3)). The loop waits for the one descriptor
// of the Client, which is readable when there is work to do.
//   g++ -std=c++17 motor_sd_event.cc $(pkg-config --cflags --libs mlcca libsystemd) -o
//   motor_sd_event
#include <sys/epoll.h>
#include <systemd/sd-event.h>

#include <chrono>
#include <iostream>

#include "mlcca/client/client.hpp"

namespace {

constexpr std::chrono::microseconds kLongestSilence(std::chrono::milliseconds(3 * 50 + 5));

struct Motor {
  sd_event_source* timer = nullptr;  // expires when the heart-beat has not come for too long
  bool runs = false;

  void set(bool now) {
    if (now != runs) std::cout << (now ? "runs" : "stops") << std::endl;
    runs = now;
  }
  void beat() {
    set(true);
    sd_event_source_set_time_relative(timer, kLongestSilence.count());
    sd_event_source_set_enabled(timer, SD_EVENT_ONESHOT);
  }
};

int on_readable(sd_event_source* /*source*/, int /*fd*/, std::uint32_t /*events*/, void* client) {
  static_cast<mlcca::client::Client*>(client)->process();
  return 0;
}

int on_silence(sd_event_source* /*source*/, std::uint64_t /*time*/, void* motor) {
  static_cast<Motor*>(motor)->set(false);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  mlcca::client::Options options;
  if (argc > 1) options.socket = argv[1];
  mlcca::client::Client client(options);
  sd_event* loop = nullptr;
  Motor motor;
  if (sd_event_default(&loop) < 0 ||
      sd_event_add_io(loop, nullptr, client.fd(), EPOLLIN, on_readable, &client) < 0 ||
      sd_event_add_time(loop, &motor.timer, CLOCK_MONOTONIC, 0, 1000, on_silence, &motor) < 0)
    return 1;
  sd_event_source_set_enabled(motor.timer, SD_EVENT_OFF);
  mlcca::client::SubscriberChannel stop(client, "stop");
  stop.on_event([&](const mlcca::client::Event&) { motor.beat(); });
  std::cout << "subscribed: " << mlcca::client::name_of(stop.subscribe()->state) << std::endl;
  return sd_event_loop(loop) < 0 ? 1 : 0;
}
