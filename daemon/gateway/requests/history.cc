// SPDX-License-Identifier: BSD-2-Clause
// History: past decisions and their reasons.
#include "daemon/store/history.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "daemon/gateway/history_pages.hpp"
#include "daemon/gateway/patience.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"
#include "daemon/system_log.hpp"

namespace mlcca::requests {
namespace {

constexpr std::uint32_t kUsual = 100;  // rows
constexpr std::uint32_t kMost = 10'000;

store::HistoryFilter filter_of(const control::HistoryRequest& request) {
  store::HistoryFilter filter;
  filter.channel = request.channel;
  filter.kind = request.kind;
  filter.since_ns = request.since_unix_ns;
  if (request.until_unix_ns != 0) filter.until_ns = request.until_unix_ns;
  filter.limit = request.limit == 0 ? kUsual : std::min(request.limit, kMost);
  return filter;
}

}  // namespace

Response history(const HistoryParts& parts, const Asker& /*asker*/,
                 const control::HistoryRequest& request) {
  if (!request.kind.empty() && !kind_named(request.kind))
    return invalid(
        fmt::format("there is no kind '{}' (there are: {})", echoed(request.kind), kind_names()));
  auto pages = std::make_shared<HistoryPages>(parts.history, filter_of(request));
  auto first = parts.patience.wait_for([&pages] { return pages->next(); });
  if (!first) return failed(first.error().text);
  if (first->entries.empty() && !request.channel.empty() &&
      !parts.scene.state->find_channel(request.channel))
    return invalid(fmt::format("no event channel is called '{}', and the history knows none",
                               echoed(request.channel)));
  if (!pages->more()) return std::move(*first);
  return Response(
      [parts, pages, first = std::move(*first)]() mutable -> std::optional<serve::Slice> {
        if (!first.entries.empty()) return serve::Slice{std::exchange(first, {}), true};
        auto page = parts.patience.wait_for([&pages] { return pages->next(); });
        if (!page) return serve::Slice{failed(page.error().text)};
        return serve::Slice{std::move(*page), pages->more()};
      });
}

}  // namespace mlcca::requests
