// SPDX-License-Identifier: BSD-2-Clause
// mlccactl generate: generates C++ and DER from the description of a system.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "description/kinds.hpp"
#include "description/read.hpp"
#include "tools/design/generate/build_files.hpp"
#include "tools/design/generate/callbacks.hpp"
#include "tools/design/generate/header.hpp"
#include "tools/design/generate/target_folder.hpp"
#include "tools/design/say.hpp"
#include "tools/design/verbs.hpp"

namespace mlcca::tools::design {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxCallbacks = std::size_t{16} << 20U;

struct Arguments {
  std::string system;
  std::vector<std::string> components;
  std::string out = "generated";
  bool force = false;
};

class Generate {
 public:
  Generate(const Arguments& arguments, const Context& context) : a_(arguments), context_(context) {}

  Exit run() { return finish(carry_out(), context_.json); }

 private:
  static std::unexpected<Refusal> refuse_to_write(const Error& why) {
    return refuse(Exit::usage, why.text + "; nothing was written");
  }

  Finished carry_out() {
    auto system = description::read(a_.system, description::Users::any);
    if (!system) {
      Refusal refusal{Exit::usage, fmt::format("{}: cannot be generated from", a_.system), {}};
      for (const auto& problem : description::shortened(system.error()))
        refusal.details.push_back(description::to_string(problem));
      return std::unexpected(std::move(refusal));
    }
    system->sort_bindings();
    const auto units = units_of(*system, a_.components);
    if (!units) return refuse(Exit::usage, units.error().text);
    if (units->empty())
      return refuse(Exit::usage, a_.system + ": no endpoint publishes or subscribes anything");
    const auto output = TargetFolder::open(a_.out);
    if (!output) return refuse(Exit::world, output.error().text);
    if (auto done = make(*system, *units, *output); !done) return done;
    return write(*output);
  }

  /// Generates all files before any is written.
  Finished make(const core::System& system, const std::vector<Unit>& units,
                const TargetFolder& output) {
    const Decisions decisions(system);
    for (const auto& unit : units) {
      auto header = header_of(system, decisions, unit);
      if (!header) return refuse(Exit::usage, header.error().text);
      const auto name = unit.stem + "_callbacks.cpp";
      if (const auto good = output.check_link(name); !good) return refuse_to_write(good.error());
      const auto old = output.read(name, kMaxCallbacks);
      if (!old) return refuse(Exit::world, old.error().text);
      auto text = *old ? std::optional((*old)->text) : std::nullopt;
      // A file of another program has no regions of ours; only --force may replace it.
      const bool foreign = text && !text->substr(0, text->find('\n')).contains(kMark);
      auto callbacks =
          callbacks_of(system, unit, header->callbacks, foreign ? std::nullopt : text, a_.force);
      if (!callbacks)
        return refuse(Exit::usage,
                      fmt::format("{}: {}", output.path(name), callbacks.error().text));
      for (const auto& region : kept_regions(*callbacks))
        notes_.push_back(
            fmt::format("{}: code of {} is kept at its end", output.path(name), region));
      files_.push_back({unit.stem + "_channels.hpp", std::move(header->text), FileKind::text});
      files_.push_back({name, std::move(*callbacks), FileKind::text});
      for (auto& blob : header->blobs)
        files_.push_back({std::move(blob.name), std::move(blob.bytes), FileKind::blob});
    }
    auto build = build_files(system, units, a_.components);
    files_.push_back({"mlcca_generated.mk", std::move(build.make), FileKind::text});
    files_.push_back({"mlcca_generated.cmake", std::move(build.cmake), FileKind::text});
    return Exit::fine;
  }

  Finished write(const TargetFolder& output) {
    for (const auto& file : files_) {
      if (const auto good = output.check_link(file.name); !good)
        return refuse_to_write(good.error());
      if (a_.force) continue;
      if (const auto good = output.check(file); !good) return refuse_to_write(good.error());
    }
    std::vector<std::pair<std::string, Written>> done;
    std::vector<std::string> names;
    const auto written = output.write(files_);
    if (!written) return refuse(Exit::world, written.error().text);
    for (std::size_t i = 0; i < files_.size(); ++i) {
      done.emplace_back(output.path(files_[i].name), (*written)[i]);
      names.push_back(files_[i].name);
    }
    if (a_.components.empty())
      for (const auto& name : output.leftovers(names))
        notes_.push_back(fmt::format("{}: belongs to no component any more; nothing removes it",
                                     output.path(name)));
    return report(done);
  }

  static const char* word_of(Written written) {
    switch (written) {
      case Written::created:
        return "created";
      case Written::changed:
        return "changed";
      case Written::unchanged:
        break;
    }
    return "unchanged";
  }

  [[nodiscard]] Exit report(const std::vector<std::pair<std::string, Written>>& done) const {
    if (context_.json) {
      auto files = Json::array();
      for (const auto& [path, written] : done)
        files.push_back({{"file", path}, {"state", word_of(written)}});
      const Json out = {{"files", std::move(files)}, {"notes", notes_}};
      return say(out.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
    }
    std::string text;
    for (const auto& [path, written] : done)
      if (written != Written::unchanged)
        text += fmt::format("{}: {}\n", printable(path), word_of(written));
    if (text.empty()) text = fmt::format("{}: nothing to change\n", printable(a_.out));
    for (const auto& note : notes_) text += fmt::format("note: {}\n", printable(note));
    return say(text);
  }

  const Arguments& a_;
  const Context& context_;
  std::vector<OutputFile> files_;
  std::vector<std::string> notes_;
};

}  // namespace

void add_generate(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("generate", "C++ and DER for the components of a system");
  auto a = std::make_shared<Arguments>();
  verb->add_option("system", a->system, "description of the system")
      ->required()
      ->type_name("SYSTEM.xml");
  verb->add_option("--component", a->components,
                   "only this component, or what sits at this place without one; repeatable")
      ->type_name("NAME")
      ->allow_extra_args(false);
  verb->add_option("--out", a->out, "folder for what is generated; default: generated")
      ->type_name("DIR");
  verb->add_flag("--force", a->force,
                 "overwrite files of others, and give up changes outside of user code");
  verb->callback([a, &context] { context.exit = Generate(*a, context).run(); });
}

}  // namespace mlcca::tools::design
