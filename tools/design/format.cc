// SPDX-License-Identifier: BSD-2-Clause
// mlccactl format: converts the lists of attributes of a description between the two forms.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "base/many.hpp"
#include "base/standard_streams.hpp"
#include "description/kinds.hpp"
#include "description/read.hpp"
#include "tools/design/format/rewrite.hpp"
#include "tools/design/output.hpp"
#include "tools/design/safe_file.hpp"
#include "tools/design/say.hpp"
#include "tools/design/verbs.hpp"

namespace mlcca::tools::design {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxFormatted = std::size_t{128} << 20U;  // bytes

struct FormatOptions {
  std::string file;
  std::string output;
  bool brief = false;
  bool paper = false;
  bool in_place = false;
  bool force = false;
};

class FormatVerb {
 public:
  FormatVerb(const FormatOptions& options, const Context& context)
      : options_(options), context_(context) {}

  Exit run() {
    const auto refused = carry_out();
    if (!refused) return exit_;
    return say(*refused, context_.json);
  }

 private:
  [[nodiscard]] std::optional<Refusal> carry_out() {
    auto file = read_file(options_.file, kMaxFormatted);
    if (!file) return Refusal{Exit::usage, file.error().text, {}};
    if (!*file)
      return Refusal{Exit::usage, fmt::format("{}: there is no such file", options_.file), {}};
    const auto problems = description::check_part(options_.file);
    if (!problems.empty()) {
      Refusal out{Exit::usage,
                  fmt::format("{}: is no valid description; nothing was written", options_.file),
                  {}};
      for (const auto& problem : description::shortened(problems))
        out.details.push_back(description::to_string(problem));
      return out;
    }
    const auto result = rewritten((*file)->text, options_.brief ? Form::brief : Form::paper);
    const bool changed = result.text != (*file)->text;
    if (options_.in_place && changed) {
      if (const auto done = replace_file(**file, result.text); !done)
        return Refusal{Exit::world, done.error().text, {}};
    } else if (!options_.output.empty()) {
      if (const auto done = write_output(options_.output, result.text, existing_if(options_.force));
          !done)
        return Refusal{Exit::world, done.error().text, {}};
    }
    report(result, changed);
    return std::nullopt;
  }

  void report(const Rewritten& result, bool changed) {
    const bool prints_text = !options_.in_place && options_.output.empty();
    if (context_.json) {
      auto kept = Json::array();
      for (const auto& one : result.kept)
        kept.push_back({{"line", one.line}, {"attribute", one.name}, {"reason", one.why}});
      Json out = {{"file", options_.file},
                  {"changed", changed},
                  {"attributes", result.attributes},
                  {"kept", std::move(kept)}};
      if (prints_text) out["text"] = result.text;
      print(out.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
      return;
    }
    if (prints_text) {
      to_stderr(kept_in_words(result));
      print(result.text);
      return;
    }
    auto text = fmt::format(
        "{}: {}\n", printable(options_.in_place ? options_.file : options_.output),
        result.attributes == 0 ? "nothing to change"
                               : fmt::format("{} in the {}", many(result.attributes, "attribute"),
                                             options_.brief ? "short form" : "form of the paper"));
    print(text + kept_in_words(result));
  }

  static std::string kept_in_words(const Rewritten& result) {
    std::string out;
    for (const auto& one : result.kept)
      out += fmt::format("  line {}: {} stays an element: {}\n", one.line, one.name, one.why);
    return out;
  }

  void print(const std::string& text) {
    if (const auto said = say(text); said != Exit::fine) exit_ = said;
  }

  const FormatOptions& options_;
  const Context& context_;
  Exit exit_ = Exit::fine;
};

}  // namespace

void add_format(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand(
      "format", "write the attributes of a description in the short form, or in the paper's");
  const auto options = std::make_shared<FormatOptions>();
  verb->add_option("file", options->file, "a description of a system, or a part of one")
      ->required()
      ->type_name("FILE");
  auto* brief = verb->add_flag("--short", options->brief, "as XML attributes: period=\"50ms\"");
  auto* paper = verb->add_flag("--paper", options->paper, "as elements, as in the paper");
  brief->excludes(paper);
  auto* in_place =
      verb->add_flag("--in-place", options->in_place, "replace the file, in one piece");
  auto* output = verb->add_option("-o,--output", options->output,
                                  "a new file, instead of standard output, which is also -")
                     ->type_name("FILE");
  in_place->excludes(output);
  add_force(*verb, output, options->force);
  verb->callback([&context, options] {
    if (!options->brief && !options->paper) throw CLI::RequiredError("--short or --paper");
    options->output = path_of_output(options->output);
    context.exit = FormatVerb(*options, context).run();
  });
}

}  // namespace mlcca::tools::design
