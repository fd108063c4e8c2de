// SPDX-License-Identifier: BSD-2-Clause
// mlccactl describe: creates and edits the description of an event channel, by options or
// questions.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/number.hpp"
#include "tools/design/describe/ask.hpp"
#include "tools/design/describe/edit.hpp"
#include "tools/design/describe/validate.hpp"
#include "tools/design/safe_file.hpp"
#include "tools/design/say.hpp"
#include "tools/design/verbs.hpp"

namespace mlcca::tools::design {
namespace {

using Json = nlohmann::ordered_json;

Refusal refusal(Exit exit, std::string message) { return {exit, std::move(message), {}}; }

/// The arguments of the verb. The order of options matters: --priority selects the set for the
/// options behind it.
struct Arguments {
  std::string file;
  std::string channel;
  std::vector<std::string> set;
  std::vector<std::string> set_user;
  std::vector<std::string> unset;
  std::vector<std::string> priority;
  std::vector<std::string> remove_set;
  std::string subject;
  std::string name;
  std::string description;
  std::string safe_side;
  bool random_subject = false;
  bool dry_run = false;
  std::vector<std::pair<std::string, std::string>> changes;  ///< options with their values, in the
                                                             ///< order of the command line
};

class Describe {
 public:
  Describe(const Arguments& arguments, const Context& context) : a_(arguments), context_(context) {}

  Exit run() {
    const auto refused = carry_out();
    return refused ? say(*refused, context_.json) : exit_;
  }

 private:
  std::optional<Refusal> carry_out() {
    auto file = read_file(a_.file, kMaxEdited);
    if (!file) return refusal(Exit::usage, file.error().text);
    file_ = std::move(*file);
    interactive_ = a_.changes.empty() && !context_.json && Terminal::is_there();
    if (a_.changes.empty() && !interactive_)
      return refusal(Exit::usage,
                     "nothing to change: say what (--set Period=50ms; --help lists the options), "
                     "or start it on a terminal to be asked");
    if (auto refused = open()) return refused;
    const auto before = file_ ? present() : ChannelText{};
    if (auto refused = interactive_ ? change_by_questions(before) : change_by_flags())
      return refused;
    if (auto refused = check_result(before)) return refused;
    return finish(changes(before, present()));
  }

  [[nodiscard]] ChannelText present() const {
    return read_channel(*markup_, *channel_nodes(*markup_).at(channel_));
  }

  [[nodiscard]] std::optional<Refusal> unusable(const std::vector<std::string>& problems,
                                                const std::string& what) const {
    if (problems.empty()) return std::nullopt;
    Refusal out{Exit::usage, fmt::format("{}: {}", a_.file, what), {}};
    for (const auto& problem : problems)
      out.details.push_back(fmt::format("{}: {}", a_.file, problem));
    return out;
  }

  std::optional<Refusal> open() {
    if (!file_) {
      if (!a_.channel.empty())
        return refusal(Exit::usage, fmt::format("{}: no such file, so there is no channel {} in it",
                                                a_.file, a_.channel));
      const auto subject = random_subject();
      if (!subject) return refusal(Exit::world, subject.error().text);
      markup_ = std::make_unique<Markup>(new_channel_file(*subject));
      return std::nullopt;
    }
    if (auto refused = unusable(problems_of_text(file_->text), "cannot be edited as it is"))
      return refused;
    markup_ = std::make_unique<Markup>(file_->text);
    return select();
  }

  std::optional<Refusal> select() {
    const auto nodes = channel_nodes(*markup_);
    std::vector<std::string> known;
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const auto channel = read_channel(*markup_, *nodes[i]);
      known.push_back(channel.name.empty() ? channel.subject : channel.name);
      if (a_.channel.empty() || a_.channel == channel.name || a_.channel == channel.subject)
        found.push_back(i);
    }
    if (known.empty())
      return refusal(Exit::usage, fmt::format("{}: there is no EventChannel in it", a_.file));
    if (found.size() == 1) {
      channel_ = found.front();
      return std::nullopt;
    }
    const auto shown = std::min<std::size_t>(known.size(), 8);
    const auto list = fmt::format(
        "{}{}", fmt::join(known.begin(), known.begin() + static_cast<std::ptrdiff_t>(shown), ", "),
        shown < known.size() ? ", ..." : "");
    if (found.empty())
      return refusal(Exit::usage, fmt::format("{}: there is no channel {}; there are {}", a_.file,
                                              a_.channel, list));
    return refusal(
        Exit::usage,
        fmt::format("{}: there are several channels; --channel says which: {}", a_.file, list));
  }

  std::optional<Refusal> change_by_flags() {
    for (const auto& [option, value] : a_.changes) {
      const auto done = change(option, value);
      if (!done) return refusal(Exit::usage, fmt::format("{}: {}", option, done.error().text));
    }
    return std::nullopt;
  }

  Result<void> change(const std::string& option, const std::string& value) {
    if (option == "--priority") return use_priority(value);
    if (option == "--remove-set") return remove_set(value);
    if (option == "--set") return set(value);
    if (option == "--set-user") return put(parse_user_defined(value));
    if (option == "--unset") return apply(*markup_, channel_, UnsetAttribute{value, priority_});
    if (option == "--subject")
      return field(SetField::Which::subject, value, problem_of_subject(value));
    if (option == "--name") return field(SetField::Which::name, value, problem_of_name(value));
    if (option == "--description")
      return field(SetField::Which::description, value, problem_of_description(value));
    if (option == "--safe-side") {
      const auto side = value == "none" ? std::string() : value;
      return field(SetField::Which::safe_side, side, problem_of_safe_side(side));
    }
    // --random-subject; a new file has a random subject already
    if (!file_) return {};
    const auto subject = random_subject();
    if (!subject) return std::unexpected(subject.error());
    return apply(*markup_, channel_, SetField{SetField::Which::subject, *subject});
  }

  Result<void> field(SetField::Which which, const std::string& text, const std::string& problem) {
    if (!problem.empty()) return fail(problem);
    return apply(*markup_, channel_, SetField{which, text});
  }

  static Result<int> number(const std::string& text) {
    const auto value = number_in<int>(text);
    if (!value || !problem_of_priority(*value).empty())
      return fail(fmt::format("'{}': must be a whole number of -1000 to 1000", text));
    return *value;
  }

  Result<void> use_priority(const std::string& text) {
    const auto priority = number(text);
    if (!priority) return std::unexpected(priority.error());
    priority_ = *priority;
    return {};
  }

  Result<void> remove_set(const std::string& text) {
    const auto priority = number(text);
    if (!priority) return std::unexpected(priority.error());
    return apply(*markup_, channel_, RemoveSet{*priority});
  }

  Result<void> set(const std::string& text) {
    const auto name = text.substr(0, text.find('='));
    const bool declared = !names_built_in(name) && declared_unit(*markup_, name);
    auto quantity = declared ? parse_user_defined(text) : parse_built_in(text);
    if (!quantity && !declared && !names_built_in(name) && text.contains('='))
      return fail(quantity.error().text + "; an attribute of your own is set by --set-user");
    return put(std::move(quantity));
  }

  Result<void> put(Result<Quantity> quantity) {
    if (!quantity) return std::unexpected(quantity.error());
    if (auto problem = problem_of(*quantity); !problem.empty()) return fail(std::move(problem));
    if (auto declared = check_declared(*markup_, *quantity); !declared) return declared;
    return apply(*markup_, channel_, SetAttribute{*quantity, priority_});
  }

  std::optional<Refusal> change_by_questions(const ChannelText& before) {
    Terminal terminal;
    const auto called = before.name.empty() ? before.subject : before.name;
    Terminal::say(file_ ? fmt::format("{}: event channel {}", a_.file, called)
                        : fmt::format("{}: a new event channel", a_.file));
    if (!ask_for_changes(terminal, *markup_, channel_)) return nothing_written();
    const auto found = changes(before, present());
    if (found.empty()) return std::nullopt;
    for (const auto& change : found) Terminal::say("  " + line(change));
    if (!confirm(terminal, fmt::format("Write {}?", a_.file))) return nothing_written();
    return std::nullopt;
  }

  [[nodiscard]] Refusal nothing_written() const {
    return refusal(Exit::refused, fmt::format("{}: nothing was written", a_.file));
  }

  [[nodiscard]] std::optional<Refusal> check_result(const ChannelText& before) const {
    const std::string what = "nothing was written, because the result would be wrong";
    if (auto refused = unusable(problems_of_text(markup_->text()), what)) return refused;
    auto problems = problems_of(*markup_, channel_);
    if (auto lost = lost_reference(*markup_, before, present()); !lost.empty())
      problems.push_back(std::move(lost));
    return unusable(problems, what);
  }

  std::optional<Refusal> finish(const std::vector<ValueChange>& found) {
    const bool changed = !file_ || markup_->text() != file_->text;
    if (changed && !a_.dry_run) {
      const auto written =
          file_ ? replace_file(*file_, markup_->text()) : create_file(a_.file, markup_->text());
      if (!written) return refusal(Exit::world, written.error().text);
    }
    if (a_.dry_run && !context_.json)
      print(markup_->text());
    else
      report(found, changed && !a_.dry_run);
    return std::nullopt;
  }

  static std::string line(const ValueChange& change) {
    if (change.before.empty())
      return fmt::format("{}: {}", printable(change.what), printable(change.after));
    if (change.after.empty())
      return fmt::format("{}: removed, was {}", printable(change.what), printable(change.before));
    return fmt::format("{}: {} -> {}", printable(change.what), printable(change.before),
                       printable(change.after));
  }

  void report(const std::vector<ValueChange>& found, bool written) {
    const auto channel = present();
    if (context_.json) {
      auto list = Json::array();
      for (const auto& c : found)
        list.push_back({{"what", c.what},
                        {"before", c.before.empty() ? Json() : Json(c.before)},
                        {"after", c.after.empty() ? Json() : Json(c.after)}});
      Json out = {{"file", a_.file},
                  {"name", channel.name.empty() ? Json() : Json(channel.name)},
                  {"subject", channel.subject},
                  {"created", !file_},
                  {"written", written},
                  {"changes", std::move(list)}};
      if (a_.dry_run) out["text"] = markup_->text();
      print(out.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
      return;
    }
    const char* done = file_ ? "changed" : "created";
    auto text = fmt::format("{}: {}\n", printable(a_.file), written ? done : "nothing to change");
    for (const auto& change : found) text += fmt::format("  {}\n", line(change));
    print(text);
  }

  void print(const std::string& text) {
    if (const auto said = say(text); said != Exit::fine) exit_ = said;
  }

  const Arguments& a_;
  const Context& context_;
  std::optional<FileContent> file_;
  std::unique_ptr<Markup> markup_;
  std::size_t channel_ = 0;  ///< index of the EventChannel in the file
  std::optional<int> priority_;
  bool interactive_ = false;
  Exit exit_ = Exit::fine;
};

/// The options that change something, with their values, in the order of the command line.
std::vector<std::pair<std::string, std::string>> in_order(const CLI::App& verb) {
  std::vector<std::pair<std::string, std::string>> out;
  std::map<const CLI::Option*, std::size_t> used;
  for (const auto* option : verb.parse_order()) {
    const auto name = option->get_name();
    if (!option->get_lnames().empty() && name != "--channel" && name != "--dry-run")
      out.emplace_back(name, option->results().at(used[option]++));
  }
  return out;
}

}  // namespace

void add_describe(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("describe", "create or edit the description of an event channel");
  auto a = std::make_shared<Arguments>();
  verb->add_option("file", a->file, "an event-channel file, or a system with channels in it")
      ->required()
      ->type_name("FILE");
  verb->add_option("--channel", a->channel, "name or subject, where the file has several")
      ->type_name("CHANNEL");
  verb->add_option("--subject", a->subject, "0x and up to 16 hexadecimal digits")
      ->type_name("0x...");
  verb->add_flag("--random-subject", a->random_subject,
                 "a random subject; the default for a new file");
  verb->add_option("--name", a->name, "short name; empty removes it")->type_name("NAME");
  verb->add_option("--description", a->description, "one line for people; empty removes it")
      ->type_name("TEXT");
  verb->add_option("--safe-side", a->safe_side,
                   "when events are lost: drop (silence is safe), deliver, or none to remove it")
      ->type_name("SIDE");
  const auto many = [&](const char* name, std::vector<std::string>& to, const char* help,
                        const char* type) {
    verb->add_option(name, to, help)->type_name(type)->allow_extra_args(false);
  };
  many("--set", a->set, "an attribute, such as Period=50ms", "NAME=VALUE");
  many("--set-user", a->set_user, "one of your own, such as Temperature=21.5K", "NAME=VALUE");
  many("--unset", a->unset, "remove an attribute", "NAME");
  many("--priority", a->priority, "the attribute set that the options behind it are for", "N");
  many("--remove-set", a->remove_set, "remove the attribute set of that priority", "N");
  verb->add_flag("--dry-run", a->dry_run, "print the result instead of writing it");
  verb->callback([a, verb, &context] {
    a->changes = in_order(*verb);
    context.exit = Describe(*a, context).run();
  });
}

}  // namespace mlcca::tools::design
