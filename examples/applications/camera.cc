// SPDX-License-Identifier: BSD-2-Clause
// A camera whose channel has two attribute sets: a picture every 20 ms, or every 80 ms where the
// networks carry no more. It follows the exceptions "degraded" and "upgraded".
//   g++ -std=c++17 camera.cc $(pkg-config --cflags --libs mlcca) -o camera
#include <algorithm>
#include <array>
#include <chrono>
#include <iostream>
#include <vector>

#include "mlcca/client/client.hpp"

namespace {

using mlcca::client::Answer;
using mlcca::client::Exception;
using std::chrono::milliseconds;

// Of each attribute set in the description, the preferred one first.
constexpr std::array<milliseconds, 2> kPeriods{milliseconds(20), milliseconds(80)};
constexpr std::size_t kPicture = 1000;  // bytes

// Of the set in use; while nothing is granted nothing is sent, and the preferred one is as good as
// any.
milliseconds period_of(const Answer& answer) {
  unsigned set = 0;
  for (const auto& delivery : answer.deliveries)
    if (delivery.granted) set = std::max(set, delivery.set);
  return kPeriods.at(set);
}

void print(const char* what, const Answer& answer) {
  std::cout << what << ": " << mlcca::client::name_of(answer.state) << ", every "
            << period_of(answer).count() << " ms" << std::endl;
}

}  // namespace

int main(int argc, char** argv) {
  using Clock = std::chrono::steady_clock;
  mlcca::client::Options options;
  if (argc > 1) options.socket = argv[1];
  mlcca::client::Client client(options);
  mlcca::client::PublisherChannel video(client, "video");
  video.on_exception([](const Exception& exception) {
    print(mlcca::client::name_of(exception.cause), *exception.answer);
  });
  print("announced", *video.announce());
  const std::vector<char> picture(kPicture);
  for (auto due = Clock::now();;) {
    video.publish(picture.data(), picture.size());
    // A picture that is late is not caught up with: two at once would be more than is granted.
    due = std::max(due + period_of(*video.answer()), Clock::now());
    for (auto now = Clock::now(); now < due; now = Clock::now())
      client.wait(std::chrono::ceil<milliseconds>(due - now));
  }
}
