// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/import/formats.hpp"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <utility>

#include "tools/design/import/cyphal.hpp"
#include "tools/design/import/dbc.hpp"
#include "tools/design/import/dds.hpp"
#include "tools/design/import/eds.hpp"

namespace mlcca::tools::design {
namespace {

/// Whether a line of the text begins with `begin`.
bool has_line(std::string_view text, std::string_view begin) {
  for (auto at = text.find(begin); at != std::string_view::npos; at = text.find(begin, at + 1))
    if (at == 0 || text[at - 1] == '\n') return true;
  return false;
}

bool is_dbc(std::string_view text) { return has_line(text, "BO_ ") || has_line(text, "BU_"); }

bool is_eds(std::string_view text) {
  return has_line(text, "[DeviceInfo]") || has_line(text, "[FileInfo]");
}

bool has_any(std::string_view text, std::initializer_list<std::string_view> words) {
  return std::ranges::any_of(words, [&](std::string_view word) { return text.contains(word); });
}

bool is_cyphal(std::string_view text) {
  return has_any(text, {"uavcan.pub.", "uavcan.sub.", "uavcan.node.id"});
}

bool is_dds_xml(std::string_view text) {
  return has_any(text, {"<data_writer", "<data_reader", "<datawriter_qos", "<datareader_qos",
                        "<publisher profile_name", "<subscriber profile_name"});
}

bool is_ros2_params(std::string_view text) { return text.contains("qos_overrides"); }

bool is_ros2_topics(std::string_view text) {
  return text.contains("Endpoint type: ") && text.contains("Node name: ");
}

/// Whether a text begins as a candump log, an ASC, pcap, pcapng or BLF file, or is packed by gzip.
bool is_recording(std::string_view text) {
  constexpr auto begins = std::to_array<std::string_view>(
      {"\xd4\xc3\xb2\xa1", "\xa1\xb2\xc3\xd4", "\x4d\x3c\xb2\xa1", "\xa1\xb2\x3c\x4d",
       "\x0a\x0d\x0d\x0a", "LOGG", "\x1f\x8b", "date "});
  if (std::ranges::any_of(begins, [&](std::string_view one) { return text.starts_with(one); }))
    return true;
  const auto line = text.substr(0, text.find('\n'));
  const auto closed = line.find(") ");
  return line.starts_with('(') && closed != std::string_view::npos && closed > 1 &&
         line.substr(1, closed - 1).find_first_not_of("0123456789.") == std::string_view::npos;
}

/// Whether the root of an XML text is one that a description has.
bool is_description(std::string_view text) {
  while (true) {
    const auto at = text.find('<');
    if (at == std::string_view::npos) return false;
    text.remove_prefix(at);
    std::string_view end;
    if (text.starts_with("<!--")) end = "-->";
    if (text.starts_with("<?")) end = "?>";
    if (end.empty()) break;
    const auto past = text.find(end);
    if (past == std::string_view::npos) return false;
    text.remove_prefix(past);
  }
  text.remove_prefix(1);
  const auto name = text.substr(0, text.find_first_of(" \t\r\n/>"));
  constexpr auto roots = std::to_array<std::string_view>(
      {"System", "Component", "Network", "Gateway", "EventChannel"});
  return std::ranges::find(roots, name) != roots.end();
}

constexpr std::array kOfDbc = {Takes::profile, Takes::bitrate, Takes::data_bitrate};
constexpr std::array kOfEds = {Takes::node, Takes::bitrate};
constexpr std::array kOfCyphal = {Takes::node, Takes::bitrate, Takes::data_bitrate};

constexpr auto kFormats = std::to_array<ImportFormat>({
    {"dbc", kOfDbc, is_dbc, import_dbc},
    {"eds", kOfEds, is_eds, import_eds},
    {"cyphal", kOfCyphal, is_cyphal, import_cyphal},
    {"dds-xml", {}, is_dds_xml, import_dds_xml},
    {"ros2-params", {}, is_ros2_params, import_ros2_params},
    {"ros2-topics", {}, is_ros2_topics, import_ros2_topics},
});

}  // namespace

const ImportFormat* recognise(std::string_view text) {
  const auto* const found =
      std::ranges::find_if(kFormats, [&](const ImportFormat& format) { return format.is(text); });
  return found == kFormats.end() ? nullptr : &*found;
}

const ImportFormat* format_called(std::string_view name) {
  const auto* const found = std::ranges::find(kFormats, name, &ImportFormat::name);
  return found == kFormats.end() ? nullptr : &*found;
}

std::vector<std::string> format_list() {
  std::vector<std::string> out;
  out.reserve(kFormats.size());
  for (const auto& format : kFormats) out.emplace_back(format.name);
  return out;
}

std::string reason_of(std::string_view text) {
  for (const auto& [begins, name] :
       {std::pair("<NetworkDefinition", "KCD"), std::pair("<AUTOSAR", "ARXML")})
    if (text.contains(begins))
      return "is " + std::string(name) +
             ", which is not read: convert it to DBC first, as canconvert of the Python package "
             "canmatrix does";
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff"))
    return "is a text in UTF-16: convert it first, by 'iconv -f UTF-16 -t UTF-8'";
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) return "is empty";
  if (is_description(text))
    return "is a description already, which nothing has to import: 'mlccactl check' checks it";
  if (is_recording(text)) return "is a recording of traffic: 'mlccactl learn' drafts from it";
  return "is in no format that is known: --format states one of " + format_names();
}

std::string format_names() {
  std::string out;
  for (const auto& format : kFormats) out += (out.empty() ? "" : ", ") + std::string(format.name);
  return out;
}

}  // namespace mlcca::tools::design
