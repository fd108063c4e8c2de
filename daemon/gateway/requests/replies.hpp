// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstddef>
#include <functional>
#include <utility>

#include "daemon/gateway/aside.hpp"
#include "daemon/gateway/requests/response.hpp"
#include "daemon/gateway/scene.hpp"

namespace mlcca {

/// Makes replies that may take too long for one turn of the loop.
class Replies {
 public:
  /// Both references must outlive this object and all replies.
  Replies(Aside& aside, const Scene& scene) : aside_(aside), scene_(scene) {}

  /// A reply that a child process makes of what is known now.
  [[nodiscard]] Response aside(const Asker& asker, Aside::Make make) const;
  /// A reply that is made now, or by a child process if it `takes_long`.
  template <class Make>
  [[nodiscard]] Response made(const Asker& asker, bool takes_long, Make make) const {
    if (takes_long) return aside(asker, std::move(make));
    return make();
  }
  /// A reply in slices, each made of what is known at its time. After a reload the rest is an
  /// error. `least_bytes`: see Response.
  [[nodiscard]] Response in_slices(std::size_t least_bytes,
                                   std::function<serve::Slice()> next) const;

 private:
  Aside& aside_;
  const Scene& scene_;
};

}  // namespace mlcca
