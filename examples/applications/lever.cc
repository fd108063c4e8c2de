// SPDX-License-Identifier: BSD-2-Clause
// The lever of an emergency stop: a program on the gateway that publishes the heart-beat "stop"
// every 50 ms, as long as the lever is not pulled, and prints what is decided for it.
//   g++ -std=c++17 lever.cc $(pkg-config --cflags --libs mlcca) -o lever
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <iostream>
#include <memory>
#include <string>

#include "mlcca/client/client.hpp"
#include "mlcca/mlcca.hpp"

namespace {

using mlcca::client::Answer;
using mlcca::client::Exception;
using namespace mlcca::literals;

// As in the description: what a node checks at compile time is announced at run time.
struct StopSpec {
  static constexpr std::uint64_t subject = 0x73746f7000000000;
  using attributes = mlcca::AttributeList<mlcca::Period<50_ms>, mlcca::Omission<2>>;
};
constexpr std::chrono::milliseconds kPeriod(50);

void print(const std::string& what, const std::shared_ptr<const Answer>& answer) {
  std::cout << what << ": " << mlcca::client::name_of(answer->state) << ", " << answer->reason
            << std::endl;
}

// Of the machine that this is to run on.
bool is_pulled() { return false; }

}  // namespace

int main(int argc, char** argv) {
  using Clock = std::chrono::steady_clock;
  mlcca::client::Options options;
  if (argc > 1) options.socket = argv[1];
  mlcca::client::Client client(options);
  mlcca::client::PublisherChannel stop(client, "stop", mlcca::values_of<StopSpec::attributes>());
  stop.on_exception([](const Exception& exception) {
    print(mlcca::client::name_of(exception.cause), exception.answer);
  });
  print("announced", stop.announce());
  for (auto due = Clock::now();;) {
    // What is not granted is not sent: the machine stands still, and the exception says why.
    if (!is_pulled()) stop.publish("go");
    // A beat that is late is not caught up with: many at once would be more than is granted.
    due = std::max(due + kPeriod, Clock::now());
    for (auto now = Clock::now(); now < due; now = Clock::now())
      client.wait(std::chrono::ceil<std::chrono::milliseconds>(due - now));
  }
}
