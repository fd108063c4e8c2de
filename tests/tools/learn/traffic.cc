// SPDX-License-Identifier: BSD-2-Clause
#include "tests/tools/learn/traffic.hpp"

#include <algorithm>

namespace mlcca::learn::test {

Traffic& Traffic::periodic(std::uint32_t interface, std::uint32_t id, std::uint64_t period,
                           std::uint64_t jitter, std::size_t bytes, std::uint64_t seconds,
                           unsigned lost) {
  const std::uint64_t begin = kSecond + below(period);
  for (std::uint64_t t = begin; t < (seconds + 1) * kSecond; t += period) {
    std::vector<std::uint8_t> data(bytes);
    for (auto& byte : data) byte = ++counter_;
    if (lost != 0 && below(lost) == 0) continue;
    all_.push_back({t + (jitter == 0 ? 0 : below(jitter)), interface, id, std::move(data)});
  }
  return *this;
}

Traffic& Traffic::bursts(std::uint32_t interface, std::uint32_t id, unsigned most,
                         std::uint64_t apart, std::uint64_t pause, std::uint64_t seconds) {
  for (std::uint64_t t = kSecond; t < (seconds + 1) * kSecond; t += pause / 2 + below(pause)) {
    const auto count = 1 + below(most);
    for (std::uint64_t i = 0; i < count; ++i)
      all_.push_back({t + i * apart, interface, id, {++counter_, 1}});
  }
  return *this;
}

Traffic& Traffic::forwarded(std::uint32_t from, std::uint32_t id, std::uint32_t to) {
  std::vector<Sent> copies;
  for (const Sent& one : all_)
    if (one.interface == from && one.id == id) copies.push_back(one);
  for (Sent& one : copies) {
    one.interface = to;
    one.ns += kMs / 5 + below(2 * kMs / 5);
    all_.push_back(std::move(one));
  }
  return *this;
}

std::vector<Sent> Traffic::sent() const {
  std::vector<Sent> out = all_;
  std::ranges::stable_sort(out, {}, &Sent::ns);
  return out;
}

}  // namespace mlcca::learn::test
