// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/say.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>

#include "tools/table.hpp"

namespace mlcca::tools::design {

Exit say(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0)
    return Exit::fine;
  fmt::print(stderr, "mlccactl: write: {}\n", ::strerror(errno));
  return Exit::world;
}

Exit say(const Refusal& refused, bool json) {
  using Json = nlohmann::ordered_json;
  if (json) {
    const Json out = {{"error",
                       {{"kind", refused.exit == Exit::world ? "world" : "invalid"},
                        {"message", refused.message},
                        {"details", refused.details}}}};
    say(out.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
    return refused.exit;
  }
  fmt::print(stderr, "mlccactl: {}\n", printable(refused.message));
  for (const auto& detail : refused.details) fmt::print(stderr, "{}\n", printable(detail));
  return refused.exit;
}

}  // namespace mlcca::tools::design
