// SPDX-License-Identifier: BSD-2-Clause
// What is believed of one link, derived from observations over time: worse values count at once,
// better ones after they have lasted.
#pragma once
#include <algorithm>
#include <cstdint>
#include <optional>

#include "core/mesh/graph.hpp"
#include "core/mesh/medium_time.hpp"
#include "core/mesh/mesh.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::core::mesh {

/// The state of a link according to all fresh reports together.
struct Observation {
  LinkQuality quality;  ///< its rate is not 0
  Value busy = 0;       ///< busy time of the medium, in 1e-6
  std::uint32_t channel = kAnyChannel;
};

/// One quantity with hysteresis: a worse value counts at once; a better one after it has lasted for
/// Mesh::hold_up if it is clearly better, otherwise for kPatience times that. Order::better(a, b,
/// mesh): a is better than b. Order::clearly(a, b, mesh): by more than Mesh::tolerance of b.
template <class T, class Order>
class Held {
 public:
  explicit Held(T value) : value_(value) {}

  [[nodiscard]] const T& value() const { return value_; }

  void observe(const T& now_seen, std::uint64_t now, const Mesh& mesh) {
    if (!Order::better(now_seen, value_, mesh)) {
      value_ = now_seen;
      rise_.reset();
      clear_rise_.reset();
    } else {
      follow(rise_, now_seen, now, mesh);
      if (Order::clearly(now_seen, value_, mesh))
        follow(clear_rise_, now_seen, now, mesh);
      else
        clear_rise_.reset();
    }
    if (now < due(mesh)) return;
    value_ =
        clear_rise_ && now >= end(clear_rise_, mesh.hold_up) ? clear_rise_->least : rise_->least;
    rise_.reset();
    clear_rise_.reset();
    // An observation that is even better starts a new rise from here.
    if (Order::better(now_seen, value_, mesh)) follow(rise_, now_seen, now, mesh);
    if (Order::clearly(now_seen, value_, mesh)) follow(clear_rise_, now_seen, now, mesh);
  }

  /// When a rise will have lasted long enough; kUnbounded if there is none.
  [[nodiscard]] std::uint64_t due(const Mesh& mesh) const {
    return std::min(end(clear_rise_, mesh.hold_up),
                    end(rise_, mul_saturating(mesh.hold_up, kPatience)));
  }

 private:
  static constexpr Value kPatience = 10;
  struct Rise {
    T least;  ///< the worst value during the rise
    std::uint64_t since = 0;
  };

  static void follow(std::optional<Rise>& rise, const T& seen, std::uint64_t now,
                     const Mesh& mesh) {
    if (!rise)
      rise = Rise{seen, now};
    else if (Order::better(rise->least, seen, mesh))
      rise->least = seen;
  }
  [[nodiscard]] static std::uint64_t end(const std::optional<Rise>& rise, Value lasting) {
    return rise ? add_saturating(rise->since, lasting) : kUnbounded;
  }

  T value_;
  std::optional<Rise> rise_;        ///< rise to any better value
  std::optional<Rise> clear_rise_;  ///< rise to clearly better values
};

/// The order of loss and busy time.
struct LessIsBetter {
  [[nodiscard]] static bool better(Value a, Value b, const Mesh&) { return a < b; }
  [[nodiscard]] static bool clearly(Value a, Value b, const Mesh& mesh) {
    return sub_floor(b, a) > mul_div_down(b, mesh.tolerance, kWhole);
  }
};

/// The order of rates. Rates of which only one includes the overhead are compared by the payload
/// that they carry in full packets. Losses are ignored.
struct FasterIsBetter {
  [[nodiscard]] static bool better(const LinkQuality& a, const LinkQuality& b, const Mesh& mesh);
  [[nodiscard]] static bool clearly(const LinkQuality& a, const LinkQuality& b, const Mesh& mesh);
};

/// The belief about one direction of a link. Times are in ns and never decrease.
class Belief {
 public:
  /// Takes an observation; nullopt: no source knows that the link carries anything.
  void observe(const std::optional<Observation>& seen, std::uint64_t now, const Mesh& mesh);

  /// Whether the link counts: it is known, and if it was lost, for long enough.
  [[nodiscard]] bool usable(std::uint64_t now) const { return seen_ && now >= usable_from_; }
  /// Whether the link is known, for long enough or not.
  [[nodiscard]] bool known() const { return seen_.has_value(); }
  /// The believed state of a usable link; its ends and weight are not set.
  [[nodiscard]] Link link() const;
  /// Whether it has been unknown for so long that it would count at once when it returns.
  [[nodiscard]] bool forgotten(std::uint64_t now, const Mesh& mesh) const {
    return !seen_ && now >= held_until(mesh);
  }
  /// The next time at which the belief changes without an observation, later than `now`;
  /// kUnbounded: never.
  [[nodiscard]] std::uint64_t deadline(std::uint64_t now, const Mesh& mesh) const;

 private:
  struct Seen {
    Held<LinkQuality, FasterIsBetter> carrier;  ///< rate and its kind
    Held<Value, LessIsBetter> loss;
    Held<Value, LessIsBetter> busy;
    bool loss_known = false;
    std::uint32_t channel = kAnyChannel;
  };

  [[nodiscard]] std::uint64_t held_until(const Mesh& mesh) const {
    return lost_at_ ? add_saturating(*lost_at_, mesh.hold_up) : 0;
  }

  std::optional<Seen> seen_;
  std::uint64_t usable_from_ = 0;
  std::optional<std::uint64_t> lost_at_;
};

}  // namespace mlcca::core::mesh
