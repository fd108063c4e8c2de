// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/requests/replies.hpp"

#include <optional>
#include <utility>

namespace mlcca {

Response Replies::aside(const Asker& asker, Aside::Make make) const {
  return Response(aside_.ask(asker.peer, std::move(make), asker.may_slice));
}

Response Replies::in_slices(std::size_t least_bytes, std::function<serve::Slice()> next) const {
  return Response(
      [&scene = scene_, description = scene_.description, next = std::move(next)] {
        if (description == scene.description) return std::optional(next());
        return std::optional(
            serve::Slice{failed("the description was reloaded meanwhile: ask again")});
      },
      least_bytes);
}

}  // namespace mlcca
