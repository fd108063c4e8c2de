// SPDX-License-Identifier: BSD-2-Clause
#include <nlohmann/json.hpp>

#include "tools/design/check/write.hpp"

namespace mlcca::tools::design {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kObjectVersion = 1;

Json to_json(const SystemReport& system) {
  Json out{{"file", system.file},
           {"name", system.system.name},
           {"readable", system.readable},
           {"usable", system.usable},
           {"inspected", system.inspected}};
  if (!system.inspected) return out;
  const auto counts = counts_of(system);
  out["channels"] = {{"all", system.inspection.channels.size()},
                     {"fit", counts.fit},
                     {"run_time", counts.run_time},
                     {"unfit", counts.unfit},
                     {"unused", counts.unused}};
  return out;
}

Json to_json(const ReportedFinding& f) {
  const auto& info = core::info(f.id);
  Json out{{"id", core::code_of(f.id)},
           {"severity", to_text(info.severity)},
           {"name", info.name},
           {"file", f.file}};
  if (f.line > 0) out["line"] = f.line;
  out["text"] = f.text;
  const auto add = [&](const char* key, const std::string& value) {
    if (!value.empty()) out[key] = value;
  };
  add("element", f.element);
  add("hint", f.hint);
  add("channel", f.channel);
  add("publisher", f.publisher);
  add("subscriber", f.subscriber);
  add("place", f.place);
  add("attribute", f.attribute);
  add("required", f.required);
  add("provided", f.provided);
  return out;
}

}  // namespace

std::string write_json(const Report& report) {
  Json out{{"version", kObjectVersion}, {"systems", Json::array()}, {"findings", Json::array()}};
  for (const auto& system : report.systems) out["systems"].push_back(to_json(system));
  for_each_finding(report,
                   [&](const ReportedFinding& f) { out["findings"].push_back(to_json(f)); });
  const auto totals = report.totals();
  out["errors"] = totals.errors;
  out["warnings"] = totals.warnings;
  out["notes"] = totals.notes;
  return out.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace mlcca::tools::design
