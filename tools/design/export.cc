// SPDX-License-Identifier: BSD-2-Clause
// mlccactl export: writes what a description admits in forms of other tools.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <expected>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "base/standard_streams.hpp"
#include "description/kinds.hpp"
#include "description/read.hpp"
#include "tools/design/export/admitted.hpp"
#include "tools/design/lacks_json.hpp"
#include "tools/design/output.hpp"
#include "tools/design/say.hpp"
#include "tools/design/verbs.hpp"

namespace mlcca::tools::design {
namespace {

using Json = nlohmann::ordered_json;

struct ExportArguments {
  std::string system;
  std::string format;
  std::string network;
  std::string gateway;
  std::string output;
  bool force = false;
};

class Export {
 public:
  Export(const ExportArguments& arguments, const Context& context)
      : a_(arguments), context_(context) {}

  Exit run() { return finish(carry_out(), context_.json); }

 private:
  Finished carry_out() {
    if (auto effect = all_have_effect(); !effect) return refuse(Exit::usage, effect.error().text);
    if (!a_.output.empty())
      if (const auto can = can_write(a_.output, existing_if(a_.force)); !can)
        return refuse(Exit::world, can.error().text);
    auto system = description::read(a_.system, description::Users::any);
    if (!system) {
      Refusal refusal{
          Exit::usage, fmt::format("{}: nothing can be exported from it", a_.system), {}};
      for (const auto& problem : description::shortened(system.error()))
        refusal.details.push_back(description::to_string(problem));
      return std::unexpected(std::move(refusal));
    }
    system->sort_bindings();
    const Admitted admitted(*system);
    auto made = make(admitted);
    if (!made) return refuse(Exit::usage, a_.system + ": " + made.error().text);
    if (!a_.output.empty())
      if (const auto written = write_output(a_.output, made->text, existing_if(a_.force)); !written)
        return refuse(Exit::world, written.error().text);
    return report(*made);
  }

  /// An error for an option that the format does not take.
  [[nodiscard]] Result<void> all_have_effect() const {
    const bool is_of_gateway = a_.format == "can-gw" || a_.format == "em_canid";
    if (!a_.network.empty() && a_.format != "dbc")
      return fail(fmt::format("--network: only dbc is of one network; {} has {}", a_.format,
                              is_of_gateway ? "those of its gateway" : "all"));
    if (!a_.gateway.empty() && !is_of_gateway)
      return fail(
          fmt::format("--gateway: only can-gw and em_canid are of one gateway, not {}", a_.format));
    return {};
  }

  [[nodiscard]] Result<Exported> make(const Admitted& admitted) const {
    const auto& system = admitted.system();
    if (a_.format == "wireshark") return export_wireshark(admitted);
    if (a_.format == "dbc") {
      const auto network =
          one_of(system.networks, a_.network, "CAN network", "--network",
                 [](const core::Network& n) { return n.kind == core::NetworkKind::can; });
      if (!network) return std::unexpected(network.error());
      return export_dbc(admitted, *network);
    }
    const auto gateway = one_of(system.gateways, a_.gateway, "gateway", "--gateway",
                                [](const core::Gateway&) { return true; });
    if (!gateway) return std::unexpected(gateway.error());
    return a_.format == "can-gw" ? export_can_gw(admitted, *gateway)
                                 : export_em_canid(admitted, *gateway);
  }

  /// The index of the element with that name; without a name the only one that fits. An error if
  /// there is none or several.
  template <class All, class Fits>
  static Result<std::size_t> one_of(const All& all, const std::string& name, const char* what,
                                    const char* option, Fits fits) {
    std::optional<std::size_t> found;
    std::string names;
    bool several = false;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (!fits(all[i])) continue;
      names += (names.empty() ? "" : ", ") + all[i].name;
      if (!name.empty() && all[i].name != name) continue;
      several = several || found.has_value();
      found = i;
    }
    if (found && !several) return *found;
    if (names.empty()) return fail(fmt::format("there is no {} to export for", what));
    if (several)
      return fail(fmt::format("there are several {}s; {} says which: {}", what, option, names));
    return fail(fmt::format("there is no such {} {}; there are {}", what, name, names));
  }

  [[nodiscard]] Finished report(const Exported& made) const {
    if (context_.json) {
      Json out = {{"output", a_.output.empty() ? Json() : Json(a_.output)},
                  {"no_counterpart", to_json(made.lacks)}};
      if (a_.output.empty()) out["text"] = made.text;
      return say(out.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
    }
    to_stderr(to_text(made.lacks, a_.system));
    return a_.output.empty() ? say(made.text) : Exit::fine;
  }

  const ExportArguments& a_;
  const Context& context_;
};

}  // namespace

void add_export(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("export", "what a description admits, for other tools");
  auto a = std::make_shared<ExportArguments>();
  verb->add_option("system", a->system, "the description of a system")
      ->required()
      ->type_name("SYSTEM.xml");
  verb->add_option("--format", a->format,
                   "dbc (messages of a CAN network), wireshark (a dissector in Lua), can-gw or "
                   "em_canid (rules for a gateway without mlccad)")
      ->required()
      ->check(CLI::IsMember({"dbc", "wireshark", "can-gw", "em_canid"}))
      ->type_name("FORM");
  verb->add_option("--network", a->network, "of dbc, where there are several CAN networks")
      ->type_name("NAME");
  verb->add_option("--gateway", a->gateway, "of can-gw and em_canid, where there are several")
      ->type_name("NAME");
  auto* output = verb->add_option("--output", a->output,
                                  "a new file, instead of standard output, which is also -")
                     ->type_name("FILE");
  add_force(*verb, output, a->force);
  verb->callback([a, &context] {
    a->output = path_of_output(a->output);
    context.exit = Export(*a, context).run();
  });
}

}  // namespace mlcca::tools::design
