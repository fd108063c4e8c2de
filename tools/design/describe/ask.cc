// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/describe/ask.hpp"

#include <fmt/format.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <functional>
#include <utility>

#include "base/standard_streams.hpp"
#include "tools/table.hpp"

namespace mlcca::tools::design {
namespace {

constexpr const char* kRemove = "-";

/// Makes the change for an answer; an error is shown and the question repeated.
using Accept = std::function<Result<void>(const std::string& answer)>;

class Questions {
 public:
  Questions(Terminal& terminal, Markup& markup, std::size_t channel)
      : terminal_(terminal), markup_(markup), channel_(channel) {}

  bool run() { return fields() && attributes(); }

 private:
  [[nodiscard]] ChannelText present() const {
    return read_channel(markup_, *channel_nodes(markup_).at(channel_));
  }

  /// Asks until an answer is accepted; an empty one keeps the present value. False at the end of
  /// input.
  bool question(const std::string& title, const std::string& now, const Accept& accept) {
    for (;;) {
      const auto answer =
          terminal_.ask(fmt::format("{} [{}]: ", title, now.empty() ? "none" : printable(now)));
      if (!answer) return false;
      if (answer->empty()) return true;
      const auto done = accept(*answer);
      if (done) return true;
      Terminal::say(fmt::format("  {}", printable(done.error().text)));
    }
  }

  bool field(SetField::Which which, const std::string& title, const std::string& now,
             std::string (*problem_of)(std::string_view)) {
    return question(title, now, [&](const std::string& answer) -> Result<void> {
      const auto text = answer == kRemove ? std::string() : answer;
      if (auto problem = problem_of(text); !problem.empty()) return fail(std::move(problem));
      return apply(markup_, channel_, SetField{which, text});
    });
  }

  bool fields() {
    const auto channel = present();
    return subject(channel.subject) &&
           field(SetField::Which::name, "Name, a short one for reports", channel.name,
                 problem_of_name) &&
           field(SetField::Which::description, "Description, one line for people",
                 channel.description, problem_of_description) &&
           field(SetField::Which::safe_side,
                 "Safe side when events are lost: drop (silence is safe, a heart-beat) or deliver "
                 "(silence is a danger)",
                 channel.safe_side, problem_of_safe_side);
  }

  bool subject(const std::string& now) {
    return question("Subject, 0x and up to 16 hexadecimal digits, or random", now,
                    [&](const std::string& answer) -> Result<void> {
                      auto text =
                          answer == "random" ? random_subject() : Result<std::string>(answer);
                      if (!text) return std::unexpected(text.error());
                      if (auto problem = problem_of_subject(*text); !problem.empty())
                        return fail(std::move(problem));
                      return apply(markup_, channel_, SetField{SetField::Which::subject, *text});
                    });
  }

  bool attributes() {
    auto sets = present().sets;
    if (sets.empty()) sets.emplace_back();
    return std::ranges::all_of(sets, [&](const AttributeSetText& set) {
      if (sets.size() > 1) Terminal::say(fmt::format("Attribute set of priority {}", set.priority));
      const auto priority = sets.size() > 1 ? std::optional(set.priority) : std::nullopt;
      return built_in(set, priority) && user_defined(set, priority) && further(priority);
    });
  }

  static std::string now_of(const AttributeSetText& set, std::string_view name) {
    const auto found = std::ranges::find(set.attributes, name, &Quantity::name);
    return found == set.attributes.end() ? std::string() : to_words(*found);
  }

  bool built_in(const AttributeSetText& set, std::optional<int> priority) {
    for (std::size_t i = 0; i < kAttributes; ++i) {
      const std::string name = kAttributeTable[i].name;
      const bool more =
          question(fmt::format("{}: {}", name, help_of(attribute_at(i))), now_of(set, name),
                   [&](const std::string& answer) -> Result<void> {
                     if (answer == kRemove)
                       return apply(markup_, channel_, UnsetAttribute{name, priority});
                     const auto quantity = parse_built_in(fmt::format("{}={}", name, answer));
                     if (!quantity) return std::unexpected(quantity.error());
                     return put(*quantity, priority);
                   });
      if (!more) return false;
    }
    return true;
  }

  bool user_defined(const AttributeSetText& set, std::optional<int> priority) {
    for (const auto& attribute : set.attributes) {
      if (names_built_in(attribute.name)) continue;
      const bool more = question(
          attribute.name + ", user-defined: a number with its unit", to_words(attribute),
          [&](const std::string& answer) -> Result<void> {
            if (answer == kRemove)
              return apply(markup_, channel_, UnsetAttribute{attribute.name, priority});
            return put_user_defined(fmt::format("{}={}", attribute.name, answer), priority);
          });
      if (!more) return false;
    }
    return true;
  }

  bool further(std::optional<int> priority) {
    for (bool another = true; another;) {
      another = false;
      const bool more = question("Another user-defined attribute, such as Temperature=21.5 K",
                                 "none", [&](const std::string& answer) {
                                   another = true;
                                   return put_user_defined(answer, priority);
                                 });
      if (!more) return false;
    }
    return true;
  }

  Result<void> put_user_defined(const std::string& text, std::optional<int> priority) {
    const auto quantity = parse_user_defined(text);
    return quantity ? put(*quantity, priority) : std::unexpected(quantity.error());
  }

  Result<void> put(const Quantity& quantity, std::optional<int> priority) {
    if (auto problem = problem_of(quantity); !problem.empty()) return fail(std::move(problem));
    if (auto declared = check_declared(markup_, quantity); !declared) return declared;
    return apply(markup_, channel_, SetAttribute{quantity, priority});
  }

  Terminal& terminal_;
  Markup& markup_;
  std::size_t channel_;
};

}  // namespace

bool Terminal::is_there() { return ::isatty(STDIN_FILENO) == 1 && ::isatty(STDERR_FILENO) == 1; }

void Terminal::say(const std::string& line) { to_stderr(line + '\n'); }

std::optional<std::string> Terminal::ask(const std::string& question) {
  to_stderr(question);
  for (;;) {
    if (const auto end = unread_.find('\n'); end != std::string::npos) {
      auto line = unread_.substr(0, end);
      unread_.erase(0, end + 1);
      const auto first = line.find_first_not_of(" \t\r");
      if (first == std::string::npos) return std::string();
      return line.substr(first, line.find_last_not_of(" \t\r") - first + 1);
    }
    std::array<char, 4096> piece{};
    const auto n = ::read(STDIN_FILENO, piece.data(), piece.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      say("");
      return std::nullopt;
    }
    unread_.append(piece.data(), static_cast<std::size_t>(n));
  }
}

bool ask_for_changes(Terminal& terminal, Markup& markup, std::size_t channel) {
  Terminal::say("Enter keeps what stands in brackets, - removes it, Ctrl-D ends without a change.");
  return Questions(terminal, markup, channel).run();
}

bool confirm(Terminal& terminal, const std::string& question) {
  for (;;) {
    const auto answer = terminal.ask(question + " [yes]: ");
    if (!answer || *answer == "no" || *answer == "n") return false;
    if (answer->empty() || *answer == "yes" || *answer == "y") return true;
    Terminal::say("  yes or no");
  }
}

Result<std::string> random_subject() {
  std::uint64_t subject = 0;
  while (subject == 0)
    if (::getrandom(&subject, sizeof(subject), 0) != static_cast<ssize_t>(sizeof(subject)))
      return fail(fmt::format("no random subject: {}", ::strerror(errno)));
  return fmt::format("0x{:016x}", subject);
}

Result<void> check_declared(const Markup& markup, const Quantity& quantity) {
  const auto unit = declared_unit(markup, quantity.name);
  if (!unit || *unit == quantity.dimension.unit) return {};
  const Quantity right{.name = quantity.name, .value = "1", .dimension = {.unit = *unit}};
  return fail(fmt::format("{}: the file declares it in another unit: such as {}", quantity.name,
                          to_words(right)));
}

}  // namespace mlcca::tools::design
