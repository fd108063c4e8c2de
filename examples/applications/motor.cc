// SPDX-License-Identifier: BSD-2-Clause
// A motor that runs as long as the heart-beat "stop" comes. It stops by itself when more events are
// missing than its Omission allows, whatever becomes of the network, the gateway or the lever.
//   g++ -std=c++17 motor.cc $(pkg-config --cflags --libs mlcca) -o motor
#include <chrono>
#include <cstdint>
#include <iostream>

#include "mlcca/client/client.hpp"
#include "mlcca/mlcca.hpp"

namespace {

using Clock = std::chrono::steady_clock;
using namespace mlcca::literals;

struct StopSpec {
  static constexpr std::uint64_t subject = 0x73746f7000000000;
  using attributes = mlcca::AttributeList<mlcca::Period<50_ms>, mlcca::Omission<2>>;
};
// (Omission + 1) * Period, and what the way may add.
constexpr std::chrono::milliseconds kLongestSilence(3 * 50 + 5);

class Motor {
 public:
  void beat() {
    last_ = Clock::now();
    set(true);
  }
  // Called at least as often as the motor must react.
  void check() {
    if (Clock::now() - last_ > kLongestSilence) set(false);
  }

 private:
  void set(bool runs) {
    if (runs != runs_) std::cout << (runs ? "runs" : "stops") << std::endl;
    runs_ = runs;
  }
  Clock::time_point last_{};
  bool runs_ = false;
};

}  // namespace

int main(int argc, char** argv) {
  mlcca::client::Options options;
  if (argc > 1) options.socket = argv[1];
  mlcca::client::Client client(options);
  Motor motor;
  mlcca::client::SubscriberChannel stop(client, "stop", mlcca::values_of<StopSpec::attributes>());
  stop.on_event([&](const mlcca::client::Event&) { motor.beat(); });
  std::cout << "subscribed: " << mlcca::client::name_of(stop.subscribe()->state) << std::endl;
  for (;;) {
    client.wait(std::chrono::milliseconds(10));
    motor.check();
  }
}
