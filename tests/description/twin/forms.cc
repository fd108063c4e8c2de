// SPDX-License-Identifier: BSD-2-Clause
#include "tests/description/twin/forms.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <string_view>
#include <utility>

#include "tests/description/twin/random_values.hpp"

namespace mlcca::testing {
namespace {

using Units = std::map<int, std::string_view>;  // by Magnitude

const Units* units_of(std::string_view name) {
  static const Units time = {{0, "s"}, {-3, "ms"}, {-6, "us"}, {-9, "ns"}};
  static const Units rate = {{0, "B/s"}, {3, "kB/s"}, {6, "MB/s"}, {9, "GB/s"}};
  static const Units loss = {{0, ""}, {-2, "%"}, {-6, "ppm"}, {-9, "ppb"}};
  static const Units whole = {{0, ""}};
  if (name == "Latency" || name == "Jitter" || name == "Deadline" || name == "Period") return &time;
  if (name == "Bandwidth") return &rate;
  if (name == "PacketLoss") return &loss;
  return name == "Omission" || name == "MaxPayload" ? &whole : nullptr;
}

/// What stands in the first element of that name, without white space.
std::string inside(std::string_view text, const std::string& element) {
  const auto from = text.find("<" + element + ">");
  if (from == std::string_view::npos) return {};
  const auto start = from + element.size() + 2;
  std::string out;
  for (const char c : text.substr(start, text.find("</", start) - start))
    if (std::isspace(static_cast<unsigned char>(c)) == 0) out += c;
  return out;
}

/// ` period="50ms"` of an Attribute element, or nothing where it has to stay one.
std::string key_of(std::string_view element) {
  if (!element.starts_with("<Attribute>")) return {};
  const auto name = inside(element, "Name");
  const auto magnitude = inside(element, "Magnitude");
  const auto value = inside(element, "Value");
  const auto* const units = units_of(name);
  if (units == nullptr) return {};
  const auto unit = units->find(magnitude.empty() ? 0 : std::stoi(magnitude));
  if (unit == units->end()) return {};
  if (units->size() == 1 && value.contains('.')) return {};
  auto key = name;
  key[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(key[0])));
  return " " + key + "=\"" + value + std::string(unit->second) + "\"";
}

/// The list that starts at the front, of which `one_in` attributes become XML attributes.
std::string shortened(std::string_view list, Random& random, std::uint64_t one_in) {
  std::string tag(list.substr(0, list.find('>')));
  list.remove_prefix(tag.size() + 1);
  std::string rest;
  constexpr std::string_view end = "</Attribute>";
  for (auto at = list.find("<Attribute"); at != std::string_view::npos;
       at = list.find("<Attribute")) {
    rest += list.substr(0, at);
    const auto size = list.find(end, at) + end.size() - at;
    const auto element = list.substr(at, size);
    const auto key = random.one_in(one_in) ? key_of(element) : std::string();
    tag += key;
    if (key.empty()) rest += element;
    list.remove_prefix(at + size);
  }
  return tag + ">" + rest + std::string(list);
}

}  // namespace

std::string in_some_forms(const std::string& text, std::uint64_t seed) {
  Random random(seed);
  std::string out;
  std::string_view left = text;
  while (!left.empty()) {
    auto from = left.size();
    std::string_view end;
    for (const auto& [tag, its_end] :
         {std::pair<std::string_view, std::string_view>{"<Attributes", "</Attributes>"},
          {"<Provision", "</Provision>"},
          {"<PerHop", "</PerHop>"}})
      if (const auto at = left.find(tag); at < from) {
        from = at;
        end = its_end;
      }
    out += left.substr(0, from);
    left.remove_prefix(from);
    if (left.empty()) break;
    const auto size = left.find(end) + end.size();
    const auto list = left.substr(0, size);
    // A half stays as it is, a quarter is short, a quarter is mixed.
    out += random.one_in(2) ? std::string(list) : shortened(list, random, 1 + random.below(2));
    left.remove_prefix(size);
  }
  return out;
}

}  // namespace mlcca::testing
