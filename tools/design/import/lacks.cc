// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/import/lacks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <ranges>
#include <utility>

#include "tools/table.hpp"

namespace mlcca::tools::design {

void Lacks::add(std::string_view kind, std::string_view what, int line, std::string item) {
  auto found = std::ranges::find(all_, kind, &Lack::kind);
  if (found == all_.end())
    found = all_.insert(
        all_.end(),
        Lack{.kind = std::string(kind), .what = std::string(what), .items = {}, .count = 0});
  ++found->count;
  if (found->items.size() < kMostItems) found->items.push_back({line, std::move(item)});
}

void Lacks::add(const Lack& of_another, std::string_view file) {
  for (const auto& item : of_another.items)
    add(of_another.kind, of_another.what, 0,
        item.line == 0 ? fmt::format("{}: {}", file, item.text)
                       : fmt::format("{}:{}: {}", file, item.line, item.text));
  const auto listed = of_another.items.size();
  std::ranges::find(all_, of_another.kind, &Lack::kind)->count += of_another.count - listed;
}

std::string to_text(const Lacks& lacks, std::string_view file) {
  std::string out;
  for (const auto& lack : lacks.all()) {
    out += fmt::format("{}: {}: {} ({})\n", printable(file), lack.kind, lack.what, lack.count);
    const std::size_t listed = std::min(lack.items.size(), kMostInText);
    for (const auto& item : lack.items | std::views::take(listed))
      out += item.line == 0
                 ? fmt::format("    {}\n", printable(item.text))
                 : fmt::format("    {}:{}: {}\n", printable(file), item.line, printable(item.text));
    if (lack.count > listed) out += fmt::format("    ... and {} more\n", lack.count - listed);
  }
  return out;
}

}  // namespace mlcca::tools::design
