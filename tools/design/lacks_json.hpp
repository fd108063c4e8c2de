// SPDX-License-Identifier: BSD-2-Clause
// Converts Lacks to JSON.
#pragma once
#include <nlohmann/json.hpp>
#include <utility>

#include "tools/design/import/lacks.hpp"

namespace mlcca::tools::design {

inline nlohmann::ordered_json to_json(const Lacks& lacks) {
  using Object = nlohmann::ordered_json;
  auto out = Object::array();
  for (const auto& lack : lacks.all()) {
    auto items = Object::array();
    for (const auto& item : lack.items)
      items.push_back(
          {{"line", item.line == 0 ? Object() : Object(item.line)}, {"text", item.text}});
    out.push_back({{"kind", lack.kind},
                   {"what", lack.what},
                   {"count", lack.count},
                   {"items", std::move(items)}});
  }
  return out;
}

}  // namespace mlcca::tools::design
