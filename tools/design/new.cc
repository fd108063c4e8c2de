// SPDX-License-Identifier: BSD-2-Clause
// The verb `mlccactl new`: makes the first description of a system from options or questions.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/number.hpp"
#include "base/standard_streams.hpp"
#include "tools/design/describe/ask.hpp"
#include "tools/design/mistakes.hpp"
#include "tools/design/new/plan.hpp"
#include "tools/design/output.hpp"
#include "tools/design/safe_file.hpp"
#include "tools/design/say.hpp"
#include "tools/design/verbs.hpp"

namespace mlcca::tools::design {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kUsualGateway = "gateway";

struct NewArguments {
  std::string file;
  std::string name;
  std::string gateway;
  std::vector<std::string> networks;
  std::vector<std::string> channels;
  bool dry_run = false;
};

/// A random number; 0 if the kernel has none yet. The caller asks again.
std::uint64_t random_number() {
  const auto text = random_subject();
  return text ? prefixed_number_in<std::uint64_t>(*text).value_or(0) : 0;
}

class New {
 public:
  New(const NewArguments& arguments, const Context& context) : a_(arguments), context_(context) {}

  Exit run() {
    if (const auto refused = carry_out()) return say(*refused, context_.json);
    return exit_;
  }

 private:
  static Refusal refusal(Exit exit, std::string message) { return {exit, std::move(message), {}}; }

  std::optional<Refusal> carry_out() {
    const bool asks = a_.networks.empty() && a_.channels.empty() && a_.gateway.empty();
    if (asks && (context_.json || !Terminal::is_there()))
      return refusal(Exit::usage,
                     "say what there is (--network bus:can:can0; --help lists the "
                     "options), or start it on a terminal to be asked");
    if (!random_subject()) return refusal(Exit::world, "the kernel gives no random numbers");
    plan_.name = a_.name;
    if (auto problem = problem_of_planned_name(plan_.name); !problem.empty())
      return refusal(Exit::usage, "--name: " + problem);
    if (asks) {
      if (!ask()) return refusal(Exit::refused, a_.file + ": nothing was written");
    } else if (auto taken = take_flags(); !taken) {
      return refusal(Exit::usage, taken.error().text);
    }
    return write();
  }

  Result<void> take_flags() {
    if (a_.networks.empty())
      return fail("--network: a system has at least one, such as --network bus:can:can0");
    const bool is_named = !a_.gateway.empty();
    if (auto set = set_gateway(is_named ? a_.gateway : kUsualGateway); !set)
      return fail("--gateway: " + set.error().text);
    if (!is_named) notes_.push_back(fmt::format("no --gateway: it is called {}", kUsualGateway));
    for (const auto& network : a_.networks)
      if (auto added = add_network(plan_, network); !added)
        return fail("--network " + added.error().text);
    for (const auto& channel : a_.channels)
      if (auto added = add_channel(plan_, channel); !added)
        return fail("--channel " + added.error().text);
    if (plan_.channels.empty())
      notes_.emplace_back("no --channel: the gateway passes nothing until one is described");
    return {};
  }

  Result<void> set_gateway(const std::string& name) {
    if (name.empty()) return {};
    if (auto problem = problem_of_planned_name(name); !problem.empty())
      return fail(std::move(problem));
    plan_.gateway = name;
    return {};
  }

  /// Asks until the answer is accepted. False at the end of the input.
  template <class Accept>
  bool question(const std::string& text, const std::string& otherwise, Accept accept) {
    for (;;) {
      auto answer = terminal_.ask(text);
      if (!answer) return false;
      const auto done = accept(answer->empty() ? otherwise : *answer);
      if (done) return true;
      Terminal::say("  " + printable(done.error().text));
    }
  }

  bool ask() {
    Terminal::say(a_.file + ": a new system. An empty answer takes what stands in brackets.");
    return question(fmt::format("Gateway, the computer between the networks [{}]: ", kUsualGateway),
                    kUsualGateway, [&](const std::string& name) { return set_gateway(name); }) &&
           several([&](bool& more) { return ask_network(more); }) &&
           several([&](bool& more) { return ask_channel(more); }) &&
           confirm(terminal_, fmt::format("Write {}?", a_.file));
  }

  /// Repeats a question until there are no more answers. False at the end of the input.
  template <class One>
  static bool several(One one) {
    for (bool more = true; more;)
      if (!one(more)) return false;
    return true;
  }

  using Fields = std::vector<std::string>;  ///< the fields of the value that an option would have
  using Add = Result<void> (*)(Plan&, std::string_view);

  static Result<void> add_fields(Plan& plan, const Fields& fields, Add add) {
    return add(plan, fmt::format("{}", fmt::join(fields, ":")));
  }

  /// Sets one field and checks it. Fields that were not asked for yet have valid values.
  Result<void> take_field(Fields& fields, std::size_t index, const std::string& answer, Add add) {
    if (answer.find(':') != std::string::npos)
      return fail(fmt::format("'{}': one thing at a time, without ':'", answer));
    Fields next = fields;
    next[index] = answer;
    Plan trial = plan_;
    if (auto done = add_fields(trial, next, add); !done) return done;
    fields = std::move(next);
    return {};
  }
  bool ask_field(const std::string& text, const std::string& otherwise, Fields& fields,
                 std::size_t index, Add add) {
    return question(
        fmt::format("  {} [{}]: ", text, otherwise), otherwise,
        [&](const std::string& answer) { return take_field(fields, index, answer, add); });
  }
  /// Asks for the first field, the name. An empty name ends the list: `more` becomes false.
  bool ask_name(const std::string& what, bool enough, Fields& fields, Add add, bool& more) {
    return question(fmt::format("{}, its name{}: ", what, enough ? " [no more]" : ""), "",
                    [&](const std::string& answer) -> Result<void> {
                      more = !answer.empty();
                      if (more) return take_field(fields, 0, answer, add);
                      if (!enough) return fail("at least one is needed");
                      return {};
                    });
  }

  bool ask_network(bool& more) {
    Fields f{"", "can", "asked-for-later"};
    if (!ask_name("Network", !plan_.networks.empty(), f, add_network, more)) return false;
    if (!more) return true;
    if (!ask_field(fmt::format("kind of {}: can, udp-multicast, udp-broadcast or mesh", f[0]),
                   "can", f, 1, add_network) ||
        !ask_field(fmt::format("interface of {} at {}", f[0], plan_.gateway), usual_interface(f[1]),
                   f, 2, add_network))
      return false;
    if (f[1] == "can") {
      f.emplace_back("500k");
      if (!ask_field("bit rate of " + f[0], "500k", f, 3, add_network)) return false;
    }
    return add_fields(plan_, f, add_network).has_value();
  }

  /// The default interface: can0, or can1 if that is already used, and so on.
  [[nodiscard]] std::string usual_interface(const std::string& kind) const {
    const std::string stem = kind.starts_with("udp-") ? "eth" : kind;
    for (std::size_t n = 0;; ++n) {
      std::string name = stem + std::to_string(n);
      if (std::ranges::find(plan_.networks, name, &PlannedNetwork::interface) ==
          plan_.networks.end())
        return name;
    }
  }

  bool ask_channel(bool& more) {
    const std::string& first = plan_.networks.front().name;
    Fields f{"", "50ms", "1", first, first};
    if (!ask_name("Channel", true, f, add_channel, more)) return false;
    if (!more) return true;
    const std::string names = fmt::format("{}", fmt::join(network_names(), ", "));
    if (!ask_field(fmt::format("Period of {}, the time from one event to the next", f[0]), "50ms",
                   f, 1, add_channel) ||
        !ask_field(fmt::format("network that it is published on, of {}", names), first, f, 3,
                   add_channel))
      return false;
    const std::string& other =
        plan_.networks.back().name == f[3] ? first : plan_.networks.back().name;
    return ask_field("networks that it is subscribed on, with commas between several", other, f, 4,
                     add_channel) &&
           ask_field("bytes of an event", "8", f, 2, add_channel) &&
           add_fields(plan_, f, add_channel).has_value();
  }
  [[nodiscard]] std::vector<std::string> network_names() const {
    std::vector<std::string> names(plan_.networks.size());
    std::ranges::transform(plan_.networks, names.begin(), &PlannedNetwork::name);
    return names;
  }

  std::optional<Refusal> write() {
    const auto text = description_that_holds(plan_, random_number);
    if (auto refused = mistakes_in(text, a_.file)) return refused;
    if (!a_.dry_run)
      if (const auto written = create_file(a_.file, text); !written)
        return refusal(Exit::world, written.error().text);
    report(text);
    return std::nullopt;
  }

  void report(const std::string& text) {
    if (context_.json) {
      Json out = {{"file", a_.file},
                  {"written", !a_.dry_run},
                  {"networks", plan_.networks.size()},
                  {"gateway", plan_.gateway},
                  {"channels", plan_.channels.size()},
                  {"notes", notes_}};
      if (a_.dry_run) out["text"] = text;
      exit_ = say(out.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
      return;
    }
    print_notes(notes_);
    if (a_.dry_run) {
      exit_ = say(text);
    } else {
      exit_ = say(fmt::format("{}: created. Now: mlccactl check {}\n", printable(a_.file),
                              printable(a_.file)));
    }
  }

  const NewArguments& a_;
  const Context& context_;
  Terminal terminal_;
  Plan plan_;
  std::vector<std::string> notes_;
  Exit exit_ = Exit::fine;
};

}  // namespace

void add_new(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("new", "the first description of a system");
  auto a = std::make_shared<NewArguments>();
  a->name = "system";
  verb->add_option("file", a->file, "is created; - is standard output")
      ->required()
      ->type_name("FILE|-");
  verb->add_option("--name", a->name, "of the system")->type_name("NAME")->capture_default_str();
  verb->add_option("--gateway", a->gateway, "with a port on each network; default: gateway")
      ->type_name("NAME");
  verb->add_option("--network", a->networks,
                   "NAME:KIND:INTERFACE, KIND is can, udp-multicast, udp-broadcast or mesh; of "
                   "can perhaps :BITRATE; may be repeated")
      ->allow_extra_args(false)
      ->type_name("NETWORK");
  verb->add_option("--channel", a->channels,
                   "NAME:PERIOD:BYTES:FROM:TO, such as speed:50ms:8:bus:lan; may be repeated")
      ->allow_extra_args(false)
      ->type_name("CHANNEL");
  verb->add_flag("--dry-run", a->dry_run, "print the description instead of writing it");
  verb->callback([a, &context] {
    if (!a->file.empty() && path_of_output(a->file).empty()) a->dry_run = true;
    context.exit = New(*a, context).run();
  });
}

}  // namespace mlcca::tools::design
