// SPDX-License-Identifier: BSD-2-Clause
// Random values, attribute sets and routes with a fixed seed, dense where arithmetic breaks.
#pragma once
#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include "mlcca/mlcca.hpp"

namespace mlcca::testing {

class RandomWorld {
 public:
  static constexpr unsigned kNever = 0;

  explicit RandomWorld(unsigned seed) : engine_(seed) {}

  std::uint64_t below(std::uint64_t n) { return engine_() % n; }
  /// Never for n = kNever.
  bool one_in(unsigned n) { return n != kNever && below(n) == 0; }

  /// Any number of bits is equally likely, and so are the edges.
  Value value() {
    static constexpr std::array<Value, 10> edges = {0,
                                                    1,
                                                    2,
                                                    (Value{1} << 32) - 1,
                                                    Value{1} << 32,
                                                    (Value{1} << 32) + 1,
                                                    Value{1} << 63,
                                                    kUnbounded - 2,
                                                    kUnbounded - 1,
                                                    kUnbounded};
    if (one_in(6)) return edges[below(edges.size())];
    return engine_() >> below(64);
  }

  /// Small enough that neighbouring values meet often.
  Value small() { return below(6); }

  Value loss() { return one_in(8) ? value() : below(kCertainLoss + 1) >> below(30); }

  Value value_of(Attribute a) {
    if (one_in(2)) return small();
    return a == Attribute::packet_loss ? loss() : value();
  }

  /// Each attribute is absent once in `absent`, and a best case once in `dynamic`.
  AttributeSet set(unsigned absent, unsigned dynamic) {
    AttributeSet result;
    for (std::size_t i = 0; i < kAttributes; ++i)
      if (!one_in(absent)) result.set(attribute_at(i), value_of(attribute_at(i)), one_in(dynamic));
    return result;
  }

  std::vector<Hop> route(std::size_t hops, unsigned absent, unsigned dynamic) {
    std::vector<Hop> result;
    result.reserve(hops);
    for (std::size_t i = 0; i < hops; ++i)
      result.push_back({set(absent, dynamic), static_cast<std::uint16_t>(below(3)),
                        static_cast<std::uint16_t>(one_in(3) ? below(9) : 1)});
    return result;
  }

  /// A value that is at least as good as v.
  Value better(Attribute a, Value v) {
    Value other = value();
    if (one_in(3)) other = add_saturating(v, 1);
    if (one_in(3)) other = sub_floor(v, 1);
    const bool smaller = info(a).better == Better::smaller;
    return smaller ? std::min(v, other) : std::max(v, other);
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace mlcca::testing
