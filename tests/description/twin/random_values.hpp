// SPDX-License-Identifier: BSD-2-Clause
// Random attributes as XML. A number is chosen in the unit of the attribute, then written with some
// Magnitude, fraction and needless zeros.
#pragma once
#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace mlcca::testing {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  std::uint64_t below(std::uint64_t n) { return engine_() % n; }
  bool one_in(std::uint64_t n) { return below(n) == 0; }
  std::uint64_t any() { return engine_(); }
  template <class Range>
  const auto& one_of(const Range& range) {
    return range[below(range.size())];
  }

 private:
  std::mt19937_64 engine_;
};

/// Kinds of quantities: how they are written, and between which bounds they are valid.
struct Quantity {
  std::string name;
  std::string unit;             ///< content of SIUnit, or empty
  int scale = 0;                ///< 10^scale units of a value are one SI unit
  std::uint64_t least = 0;      ///< in units
  std::uint64_t most = 0;       ///< in units
  bool larger = false;          ///< larger values are better
  bool providable = true;       ///< may stand in a Provision
  bool survival = false;        ///< is a fraction that adds up over frames
  std::string definition = {};  ///< the UserAttribute, or empty
};

/// The eight of the table. `most_payload` bounds MaxPayload.
std::vector<Quantity> built_in_quantities(std::uint64_t most_payload);

/// One that a description defines by itself, with that name.
Quantity user_quantity(Random& random, const std::string& name);

/// Which numbers are likely to meet in one system.
class Numbers {
 public:
  explicit Numbers(Random& random);

  /// Content of Name, Dimension and Value, with a number between the bounds of `quantity`.
  std::string attribute(Random& random, const Quantity& quantity);
  /// The same with the best or the worst number that there is.
  static std::string attribute(Random& random, const Quantity& quantity, bool best);

 private:
  static std::string written(Random& random, const Quantity& quantity, std::uint64_t number,
                             const std::string& fraction);

  std::array<std::uint64_t, 3> favourites_{};
};

}  // namespace mlcca::testing
