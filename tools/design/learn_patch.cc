// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/learn_patch.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <functional>

#include "base/handle.hpp"
#include "tools/design/describe/layout.hpp"
#include "tools/design/safe_file.hpp"
#include "tools/elements.hpp"

extern char** environ;  // NOLINT(*-redundant-declaration): not in every C library's headers

namespace mlcca::tools::design {
namespace {

constexpr std::size_t kLargestPatched = 16U << 20U;  // as for `describe`

/// The element of that name that begins on that line.
const Node* element_at(const Node& node, std::string_view name, int line) {
  if (node.name == name && node.line == line) return &node;
  for (const Node& child : node.children)
    if (const Node* found = element_at(child, name, line)) return found;
  return nullptr;
}

/// The beginning of the line with the end tag if only blanks precede the tag, else the position of
/// the tag.
std::size_t before_end_tag(const Markup& markup, const Node& node) {
  const std::string& text = markup.text();
  std::size_t at = node.content.to;
  while (at > node.content.from && (text[at - 1] == ' ' || text[at - 1] == '\t')) --at;
  return at > 0 && text[at - 1] == '\n' ? at : node.content.to;
}

/// The root, whatever its line, for the element System.
Result<const Node*> node_in(const Markup& markup, const std::string& path, std::string_view element,
                            int line) {
  const Node* const node =
      element == "System" ? &markup.root() : element_at(markup.root(), element, line);
  if (node != nullptr && node->name == element) return node;
  return fail(fmt::format("{}: no <{}> begins in line {} any more", path, element, line));
}

std::string_view name_of_element(LearnPatch::Element element) {
  constexpr std::array<std::string_view, 4> names = {"EventChannel", "Publisher", "Gateway",
                                                     "Network"};
  return names.at(static_cast<std::size_t>(element));
}

}  // namespace

void LearnPatch::state(const Stated& attribute, std::uint64_t value) {
  const auto [known, fresh] = values_.try_emplace(attribute, value);
  if (fresh) return;
  known->second =
      attribute.key == "period" ? std::min(known->second, value) : std::max(known->second, value);
}

/// The file as it is, with its elements.
Result<const Markup*> LearnPatch::markup_of(std::uint32_t file) {
  if (file >= system_.files.size()) return fail("the description has no such file");
  const std::string& path = system_.files[file];
  if (const auto known = markups_.find(path); known != markups_.end()) return &known->second;
  const auto content = read_file(path, kLargestPatched);
  if (!content) return std::unexpected(content.error());
  if (!*content) return fail(path + ": is gone");
  return &markups_.try_emplace(path, (*content)->text).first->second;
}

/// Before the end tag of an element.
Result<void> LearnPatch::insert(const core::Origin& of, std::string_view element,
                                const std::string& text, Changes& to) {
  const auto markup = markup_of(of.file);
  if (!markup) return std::unexpected(markup.error());
  const std::string& path = system_.files[of.file];
  const auto node = node_in(**markup, path, element, of.line);
  if (!node) return std::unexpected(node.error());
  if (!(*node)->has_end_tag)
    return fail(
        fmt::format("{}:{}: <{}/> has no end tag to put elements before", path, of.line, element));
  to.insertions[path].push_back({before_end_tag(**markup, **node), text});
  return {};
}

Result<void> LearnPatch::change(const Stated& attribute, std::uint64_t value, Changes& to) {
  const auto markup = markup_of(attribute.of.file);
  if (!markup) return std::unexpected(markup.error());
  const std::string& path = system_.files[attribute.of.file];
  const auto node = node_in(**markup, path, name_of_element(attribute.element), attribute.of.line);
  if (!node) return std::unexpected(node.error());
  const bool provides =
      attribute.element == Element::gateway || attribute.element == Element::network;
  const std::string_view name = provides ? "Provision" : "Attributes";
  const std::string words =
      attribute.key == "maxPayload" ? std::to_string(value) : time_words(value);
  const std::string fresh = fmt::format(" {}=\"{}\"", attribute.key, words);
  const Node* const list = (*node)->child(name);
  if (list == nullptr) {
    if (attribute.element == Element::publisher)
      to.lists[{attribute.of.file, attribute.of.line}] += fresh;
    return {};
  }
  if (!list->children.empty() || std::ranges::count((*node)->children, name, &Node::name) > 1)
    return {};
  auto& all = to.insertions[path];
  if (const auto* const there = list->attribute(attribute.key); there != nullptr)
    all.push_back({there->value.from, words, there->value.to - there->value.from});
  else
    all.push_back({list->start_tag.from + 1 + list->name.size(), fresh});
  return {};
}

/// Publishers that state nothing of their own get a list.
Result<void> LearnPatch::add_lists(Changes& to) {
  for (const auto& [where, attributes] : to.lists) {
    const auto markup = markup_of(where.first);
    if (!markup) return std::unexpected(markup.error());
    const std::string& path = system_.files[where.first];
    const auto node = node_in(**markup, path, "Publisher", where.second);
    if (!node) return std::unexpected(node.error());
    const std::string& text = (*markup)->text();
    const std::string end =
        std::string((*markup)->newline()) + indentation(text, (*node)->whole.from);
    const std::string list = fmt::format("{}{}<Attributes{}/>", end, step(**markup), attributes);
    if ((*node)->has_end_tag) {
      to.insertions[path].push_back({(*node)->content.from, list});
      continue;
    }
    const auto slash = text.rfind('/', (*node)->start_tag.to);
    to.insertions[path].push_back(
        {slash, fmt::format(">{}{}</Publisher>", list, end), (*node)->start_tag.to - slash});
  }
  return {};
}

Result<LearnPatch::Changes> LearnPatch::changes() {
  Changes out;
  for (const auto& [attribute, value] : values_)
    if (const auto made = change(attribute, value, out); !made)
      return std::unexpected(made.error());
  if (const auto made = add_lists(out); !made) return std::unexpected(made.error());
  if (!in_system_.empty())
    if (const auto made = insert({0, 1}, "System", in_system_, out); !made)
      return std::unexpected(made.error());
  for (const auto& [network, text] : in_networks_)
    if (const auto made = insert(network, "Network", text, out); !made)
      return std::unexpected(made.error());
  return out;
}

Result<std::vector<std::pair<std::string, std::string>>> LearnPatch::files() {
  auto wanted = changes();
  if (!wanted) return std::unexpected(wanted.error());
  std::vector<std::pair<std::string, std::string>> out;
  for (auto& [path, all] : wanted->insertions) {
    if (all.empty()) continue;
    // From the end, so that earlier offsets stay valid.
    std::ranges::stable_sort(all, std::ranges::greater{}, &Insertion::at);
    std::string text = markups_.at(path).text();
    for (const Insertion& one : all) text.replace(one.at, one.instead_of, one.text);
    out.emplace_back(path, std::move(text));
  }
  return out;
}

Result<std::string> diff_of(const std::string& path, const std::string& text) {
  const auto system_error = [](const char* call) {
    return fail(std::string(call) + ": " + std::strerror(errno));  // NOLINT(concurrency-mt-unsafe)
  };
  const Fd changed(::memfd_create("changed", MFD_CLOEXEC));
  const Fd out(::memfd_create("diff", MFD_CLOEXEC));
  if (!changed || !out) return system_error("memfd_create");
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t n = ::write(changed.get(), text.data() + at, text.size() - at);
    if (n < 0) return system_error("write");
    at += static_cast<std::size_t>(n);
  }
  if (::lseek(changed.get(), 0, SEEK_SET) < 0) return system_error("lseek");
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, changed.get(), STDIN_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, out.get(), STDOUT_FILENO);
  std::array<std::string, 7> words{"diff", "-u", "--label=" + path, "--label=" + path, "--",
                                   path,   "-"};
  std::array<char*, words.size() + 1> arguments{};
  std::ranges::transform(words, arguments.begin(), [](std::string& word) { return word.data(); });
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, "diff", &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return fail(std::string("diff: ") + std::strerror(error));  // NOLINT(*-mt-unsafe)
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return system_error("waitpid");
  if (!WIFEXITED(status) || WEXITSTATUS(status) > 1) return fail("diff has failed");
  std::string result;
  std::array<char, 65'536> buffer{};
  ::lseek(out.get(), 0, SEEK_SET);
  for (ssize_t n = 0; (n = ::read(out.get(), buffer.data(), buffer.size())) > 0;)
    result.append(buffer.data(), static_cast<std::size_t>(n));
  return result;
}

}  // namespace mlcca::tools::design
