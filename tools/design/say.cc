// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/say.hpp"

#include <nlohmann/json.hpp>
#include <string>

#include "base/standard_streams.hpp"
#include "tools/table.hpp"

namespace mlcca::tools::design {

Exit say(std::string_view text) { return printed("mlccactl", text) ? Exit::fine : Exit::world; }

Exit say(const Refusal& refused, bool json) {
  using Json = nlohmann::ordered_json;
  if (json) {
    const Json out = {{"error",
                       {{"kind", refused.exit == Exit::world ? "world" : "invalid"},
                        {"message", refused.message},
                        {"details", refused.details}}}};
    const Exit said = say(out.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
    return said == Exit::fine ? refused.exit : said;
  }
  std::string lines = "mlccactl: " + printable(refused.message) + '\n';
  for (const auto& detail : refused.details) lines += printable(detail) + '\n';
  to_stderr(lines);
  return refused.exit;
}

void print_notes(const std::vector<std::string>& notes) {
  std::string lines;
  for (const std::string& note : notes) lines += "note: " + printable(note) + '\n';
  to_stderr(lines);
}

}  // namespace mlcca::tools::design
