// SPDX-License-Identifier: BSD-2-Clause
// Any fragments, of any sources, at any times. The first octet says which network; then each
// fragment has its source, the time since the one before it in 16 ms, its length, and its octets.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>

#include "relay/afp.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using namespace mlcca::relay::afp;
using mlcca::fuzz::demand;

constexpr Form kForms[] = {
    kCan, {.payload = 1392, .numbered = true}, {.payload = 16, .numbered = true}};
constexpr Reassembly::Limits kLimits{.begun = 8, .octets = 8'000, .remembered = 8};
constexpr std::uint64_t kStep = 16'000'000;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const Form form = kForms[data[0] % std::size(kForms)];
  std::span<const std::uint8_t> rest(data + 1, size - 1);
  Reassembly reassembly(form, kLimits);
  std::uint64_t now = 0;
  while (rest.size() >= 3) {
    const std::uint8_t source = rest[0];
    now += rest[1] * kStep;
    const std::size_t length = std::min<std::size_t>(rest[2], rest.size() - 3);
    const auto event = reassembly.take(source, rest.subspan(3, length), now);
    rest = rest.subspan(3 + length);
    demand(!event || event->size() <= longest_event(form), "an event that is longer than any");
    demand(reassembly.begun() <= kLimits.begun, "too many events are begun");
    demand(reassembly.octets() <= kLimits.octets, "too much is kept");
    demand(reassembly.remembered() <= kLimits.remembered, "too much is remembered");
  }
  static_cast<void>(reassembly.take(0, {}, now + kLimits.lifetime_ns));
  demand(reassembly.begun() == 0 && reassembly.octets() == 0 && reassembly.remembered() == 0,
         "something is kept for ever");
  return 0;
}
