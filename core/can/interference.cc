// SPDX-License-Identifier: BSD-2-Clause
#include "core/can/interference.hpp"

#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

#include "core/can/analysis.hpp"

namespace mlcca::core::can {
namespace {

template <class T>
auto place(std::vector<T>& values, std::size_t at) {
  return values.begin() + static_cast<std::ptrdiff_t>(at);
}

}  // namespace

Share share_of(Time part, Time whole) {
  if (part >= whole) return kAllShare;
  constexpr unsigned half = kShareBits / 2;  // in two steps, so that both products fit 64 bits
  const Time high = (part << half) / whole;
  const Time rest = (part << half) % whole;
  return (high << half) + ((rest << half) + whole - 1) / whole;
}

void Interference::insert(std::size_t at, const Message& message, Time jitter) {
  const Time period = std::min(message.period, kLongestTime);
  // ceil(2^(64 + shift) / period), with the largest shift for which it fits 64 bits.
  const auto shift = static_cast<std::uint32_t>(std::bit_width(period - 1) - 1);
  const Product power = Product{1} << (64 + shift);
  reciprocal_.insert(place(reciprocal_, at),
                     static_cast<std::uint64_t>((power + period - 1) / period));
  shift_.insert(place(shift_, at), shift);
  cost_.insert(place(cost_, at), message.transmission);
  share_.insert(place(share_, at), share_of(message.transmission, period));
  offset_.insert(place(offset_, at), jitter + bit_ - 1);
  fixed_.insert(place(fixed_, at), 0);
  set_fixed(at);
}

void Interference::erase(std::size_t at) {
  reciprocal_.erase(place(reciprocal_, at));
  shift_.erase(place(shift_, at));
  cost_.erase(place(cost_, at));
  share_.erase(place(share_, at));
  offset_.erase(place(offset_, at));
  fixed_.erase(place(fixed_, at));
}

void Interference::swap(std::size_t a, std::size_t b) {
  std::swap(reciprocal_[a], reciprocal_[b]);
  std::swap(shift_[a], shift_[b]);
  std::swap(cost_[a], cost_[b]);
  std::swap(share_[a], share_[b]);
  std::swap(offset_[a], offset_[b]);
  std::swap(fixed_[a], fixed_[b]);
}

void Interference::set_jitter(std::size_t at, Time jitter) {
  offset_[at] = jitter + bit_ - 1;
  set_fixed(at);
}

void Interference::set_fixed(std::size_t i) {
  // floor(x / T) * C + C <= C + x * C / T
  const auto part = Product{share_[i]} * offset_[i];
  fixed_[i] = cost_[i] + static_cast<Time>(part >> kShareBits) + 1;
}

Share Interference::share(std::size_t first, std::size_t last) const {
  return std::accumulate(share_.begin() + static_cast<std::ptrdiff_t>(first),
                         share_.begin() + static_cast<std::ptrdiff_t>(last), Share{0});
}

}  // namespace mlcca::core::can
