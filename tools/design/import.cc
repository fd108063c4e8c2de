// SPDX-License-Identifier: BSD-2-Clause
// The verb `mlccactl import`: makes descriptions from files of other tools.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <expected>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/many.hpp"
#include "base/standard_streams.hpp"
#include "core/model/words.hpp"
#include "tools/design/import/draft.hpp"
#include "tools/design/import/formats.hpp"
#include "tools/design/lacks_json.hpp"
#include "tools/design/mistakes.hpp"
#include "tools/design/output.hpp"
#include "tools/design/safe_file.hpp"
#include "tools/design/say.hpp"
#include "tools/design/verbs.hpp"
#include "tools/values.hpp"

namespace mlcca::tools::design {
namespace {

using Json = nlohmann::ordered_json;

struct ImportArguments {
  std::vector<std::string> files;
  std::vector<std::string> networks;
  std::vector<std::string> interfaces;
  std::vector<unsigned> nodes;
  std::string format;
  std::string gateway;
  std::string name = "imported";
  std::string period;
  std::string bitrate;
  std::string data_bitrate;
  std::string profile;
  std::string output;
};

class Import {
 public:
  Import(const ImportArguments& arguments, const Context& context)
      : a_(arguments), context_(context) {}

  Exit run() { return finish(carry_out(), context_.json); }

 private:
  Finished carry_out() {
    if (!a_.output.empty())
      if (const auto can = can_write(a_.output, Existing::refuse); !can)
        return refuse(Exit::world, can.error().text);
    if (auto good = understand(); !good) return refuse(Exit::usage, good.error().text);
    if (std::ranges::count_if(a_.files, is_standard) > 1)
      return refuse(Exit::usage, "- is given twice: standard input is one file");
    for (std::size_t i = 0; i < a_.files.size(); ++i)
      if (auto done = read(a_.files[i], i); !done) return done;
    if (auto effect = all_have_effect(); !effect) return refuse(Exit::usage, effect.error().text);
    for (auto& network : networks_) complete(network);
    if (!a_.interfaces.empty() && a_.interfaces.size() != networks_.size())
      return refuse(Exit::usage, fmt::format("--interface is given {} for {}: give it once for "
                                             "each, in their order",
                                             many(a_.interfaces.size(), "time"),
                                             many(networks_.size(), "network")));
    const auto draft = draft_of(networks_, {a_.name, a_.gateway, a_.interfaces});
    if (auto refused = mistakes_in(draft, "draft")) return std::unexpected(std::move(*refused));
    if (!a_.output.empty())
      if (const auto written = write_output(a_.output, draft, Existing::refuse); !written)
        return refuse(Exit::world, written.error().text);
    return report(draft);
  }

  Result<void> understand() {
    if (!a_.networks.empty() && a_.networks.size() != a_.files.size())
      return fail(fmt::format("--network is given {} for {}: give it once for each, in their order",
                              many(a_.networks.size(), "time"), many(a_.files.size(), "file")));
    if (!a_.nodes.empty() && a_.nodes.size() != a_.files.size())
      return fail("--node is given once for each file, or not at all");
    if (a_.gateway.empty() != a_.interfaces.empty())
      return fail(
          "--gateway and --interface go together: a gateway has an interface on each network");
    std::vector<std::string> names = {a_.name};
    names.insert(names.end(), a_.networks.begin(), a_.networks.end());
    if (!a_.gateway.empty()) names.push_back(a_.gateway);
    for (const auto& name : names)
      if (name_from(name) != name)
        return fail(
            fmt::format("'{}': a name is a letter, then up to 62 letters, digits, dots, "
                        "underscores or hyphens",
                        name));
    if (!a_.period.empty()) {
      const auto period = parse_attribute("Period=" + a_.period, Role::offered);
      if (!period) return fail("--default-period: " + period.error().text);
      options_.default_period = period->value;
      if (options_.default_period == 0) return fail("--default-period: must be more than 0");
    }
    if (!a_.profile.empty()) options_.profile = core::words::kProfiles.find(a_.profile);
    if (auto good = rate("--bitrate", a_.bitrate, 1'000'000, options_.bitrate); !good) return good;
    return rate("--data-bitrate", a_.data_bitrate, 8'000'000, options_.data_bitrate);
  }

  /// An error for an option that none of the files can have.
  [[nodiscard]] Result<void> all_have_effect() const {
    const struct {
      bool is_given;
      Takes takes;
      const char* why;
    } options[] = {
        {!a_.nodes.empty(), Takes::node, "--node: only eds and cyphal files have a node"},
        {!a_.profile.empty(), Takes::profile, "--profile: only dbc files have one to choose"},
        {!a_.bitrate.empty(), Takes::bitrate,
         "--bitrate: only dbc, eds and cyphal files are of a bus"},
        {!a_.data_bitrate.empty(), Takes::data_bitrate,
         "--data-bitrate: only dbc and cyphal files may have FD frames"}};
    for (const auto& option : options)
      if (option.is_given && !takes_.contains(option.takes))
        return fail(fmt::format("{}, and none is given", option.why));
    return {};
  }

  static Result<void> rate(const char* option, const std::string& text, std::uint32_t most,
                           std::uint32_t& to) {
    if (text.empty()) return {};
    const auto read = parse_bus_rate(text, most);
    if (!read) return fail(fmt::format("{} {}", option, read.error().text));
    to = *read;
    return {};
  }

  static bool is_standard(const std::string& path) { return path == "-"; }

  /// The content of a file, or of standard input.
  static Result<std::string> text_of(const std::string& path) {
    if (is_standard(path)) return read_standard_input(kMostImported);
    auto file = read_file(path, kMostImported);
    if (!file) return std::unexpected(file.error());
    if (!*file) return fail(path + ": No such file or directory");
    return std::move((*file)->text);
  }

  Finished read(const std::string& path, std::size_t i) {
    const auto text = text_of(path);
    if (!text)
      return refuse(Exit::usage,
                    text.error().text + (text.error().text.contains("that is the limit")
                                             ? ". If it is a recording, use 'mlccactl learn'"
                                             : ""));
    const std::string called = is_standard(path) ? "standard input" : path;
    const auto* format = a_.format.empty() ? recognise(*text) : format_called(a_.format);
    if (format == nullptr)
      return refuse(Exit::usage, fmt::format("{}: {}", called, reason_of(*text)));
    takes_.insert(format->takes.begin(), format->takes.end());
    options_.node = a_.nodes.empty() ? 0 : a_.nodes[i];
    auto network = format->read(*text, called, options_);
    if (!network) return refuse(Exit::usage, network.error().text);
    network->name = a_.networks.empty()
                        ? name_from(is_standard(path) ? "stdin" : stem_of_file(path))
                        : a_.networks[i];
    for (auto& other : networks_) {
      if (other.name != network->name) continue;
      if (!may_merge(other, *network))
        return refuse(Exit::usage, fmt::format("{}: the network {} is that of {}: give each a name "
                                               "by --network",
                                               path, network->name, other.file));
      merge(other, std::move(*network));
      return Exit::fine;
    }
    networks_.push_back(std::move(*network));
    return Exit::fine;
  }

  /// Whether two files describe nodes of one network.
  static bool may_merge(const ImportedNetwork& a, const ImportedNetwork& b) {
    return a.is_part && b.is_part && a.kind == b.kind && a.profile == b.profile;
  }

  [[nodiscard]] Finished report(const std::string& draft) const {
    if (context_.json)
      return say(json(draft).dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
    for (const auto& network : networks_) {
      to_stderr(to_text(network.lacks, network.file) +
                fmt::format("{}: {} of {}\n", printable(network.file),
                            many(network.messages.size(), "message"),
                            many(network.nodes.size(), "node")));
    }
    return a_.output.empty() ? say(draft) : Exit::fine;
  }

  [[nodiscard]] Json json(const std::string& draft) const {
    auto networks = Json::array();
    for (const auto& network : networks_) {
      networks.push_back({{"file", network.file},
                          {"network", network.name},
                          {"messages", network.messages.size()},
                          {"nodes", network.nodes.size()},
                          {"no_counterpart", to_json(network.lacks)}});
    }
    Json out = {{"output", a_.output.empty() ? Json() : Json(a_.output)},
                {"networks", std::move(networks)}};
    if (a_.output.empty()) out["text"] = draft;
    return out;
  }

  const ImportArguments& a_;
  const Context& context_;
  ImportOptions options_;
  std::vector<ImportedNetwork> networks_;
  std::set<Takes> takes_;  ///< what at least one of the files takes
};

}  // namespace

void add_import(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand(
      "import", "describe a network from DBC, CANopen, Cyphal, ROS 2 or DDS files");
  auto a = std::make_shared<ImportArguments>();
  verb->add_option("file", a->files, "each becomes a network; - is standard input")
      ->required()
      ->type_name("FILE|-");
  verb->add_option("--format", a->format, "of the files; otherwise recognised by their content")
      ->check(CLI::IsMember(format_list()))
      ->type_name("FORM");
  verb->add_option("--name", a->name, "of the system")->type_name("NAME")->capture_default_str();
  verb->add_option(
          "--network", a->networks,
          "name of the network, once for each file; otherwise the file's name; files of nodes "
          "(CANopen, Cyphal, ROS 2, DDS) with one name are one network")
      ->allow_extra_args(false)
      ->type_name("NAME");
  verb->add_option("--gateway", a->gateway, "a gateway with a port on each network")
      ->type_name("NAME");
  verb->add_option("--interface", a->interfaces, "of that gateway, once for each network")
      ->allow_extra_args(false)
      ->type_name("NAME");
  verb->add_option("--profile", a->profile,
                   "raw or j1939, of a DBC file; otherwise j1939 if all its messages are")
      ->check(CLI::IsMember({"raw", "j1939"}))
      ->type_name("PROFILE");
  verb->add_option("--node", a->nodes,
                   "of a CANopen or Cyphal file that states none, 1 to 127, once for each file")
      ->check(CLI::Range(1U, 127U))
      ->allow_extra_args(false)
      ->type_name("N");
  verb->add_option("--bitrate", a->bitrate,
                   "of the bus, such as 500k; otherwise what the file states, or 500k")
      ->type_name("BIT/S");
  verb->add_option("--data-bitrate", a->data_bitrate,
                   "of the data phase of FD frames; otherwise what the file states, or 2M")
      ->type_name("BIT/S");
  verb->add_option("--default-period", a->period,
                   "of a message for which the file states no cycle time, by default 100ms")
      ->type_name("TIME");
  verb->add_option("--output", a->output, "a new file, instead of standard output, which is also -")
      ->type_name("FILE");
  verb->callback([a, &context] {
    a->output = path_of_output(a->output);
    context.exit = Import(*a, context).run();
  });
}

}  // namespace mlcca::tools::design
