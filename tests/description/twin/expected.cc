// SPDX-License-Identifier: BSD-2-Clause
#include "tests/description/twin/expected.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>
#include <vector>

#include "core/design/findings.hpp"
#include "core/design/inspect.hpp"

namespace mlcca::testing {
namespace {

/// What stands between "<!-- expect: " and " -->".
std::vector<std::string> expectations_in(const std::string& text) {
  static const std::string start = "<!-- expect: ";
  std::vector<std::string> out;
  for (auto at = text.find(start); at != std::string::npos; at = text.find(start, at + 1)) {
    const auto first = at + start.size();
    out.push_back(text.substr(first, text.find(" -->", first) - first));
  }
  return out;
}

bool is_note(const std::string& id) { return id >= "MLCCA038" && id <= "MLCCA041"; }

bool is_common(const std::string& id) {
  return is_note(id) || id == "MLCCA010" || id == "MLCCA020" || id == "MLCCA021";
}

}  // namespace

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

Keys expected_in(const std::string& text) {
  Keys out;
  for (const auto& line : expectations_in(text)) {
    std::istringstream words(line);
    Key key;
    words >> key.id;
    if (!is_common(key.id)) continue;
    if (key.id == "MLCCA040" || key.id == "MLCCA041")
      words >> key.hop >> key.network;
    else if (is_note(key.id))
      words >> key.publisher >> key.subscriber >> key.attribute;
    else if (key.id == "MLCCA010")
      words >> key.subscriber;
    else
      words >> key.publisher >> key.subscriber >> key.hop >> key.attribute >> key.required >>
          key.provided;
    for (std::string* const part : {&key.publisher, &key.subscriber, &key.hop})
      if (*part == "-") part->clear();
    if (key.provided == "not-provided") key.provided = "not provided";
    out.insert(std::move(key));
  }
  return out;
}

std::set<std::string> others_expected_in(const std::string& text) {
  std::set<std::string> out;
  for (const auto& line : expectations_in(text))
    if (!is_common(line.substr(0, line.find(' ')))) out.insert(line);
  return out;
}

std::set<std::string> others_of(core::System system) {
  for (auto& network : system.networks)
    std::ranges::sort(network.bindings, {}, &core::Binding::channel);
  std::set<std::string> out;
  for (const auto& f : core::inspect(system).findings) {
    const auto id = core::code_of(f.id);
    if (is_common(id)) continue;
    out.insert(id + " " +
               (f.publisher != core::kNone ? system.publishers[f.publisher].name
                                           : system.channels[f.channel].name));
  }
  return out;
}

std::string listed(const Keys& keys) {
  std::string out;
  for (const auto& key : keys) out += "\n  " + to_string(key);
  return out;
}

}  // namespace mlcca::testing
