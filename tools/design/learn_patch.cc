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
#include <set>

#include "base/handle.hpp"
#include "tools/design/describe/layout.hpp"
#include "tools/design/safe_file.hpp"
#include "tools/elements.hpp"
#include "tools/learn/channels.hpp"

extern char** environ;  // NOLINT(*-redundant-declaration): not in every C library's headers

namespace mlcca::tools::design {
namespace {

constexpr std::size_t kLargestPatched = 16U << 20U;  // as for `describe`

/// The elements of that name that begin on that line, in their order.
void add_elements_at(const Node& node, std::string_view name, int line,
                     std::vector<const Node*>& out) {
  if (node.name == name && node.line == line) out.push_back(&node);
  for (const Node& child : node.children) add_elements_at(child, name, line, out);
}

/// An element of the system, and which one it is of those of its kind that begin on its line.
struct InSystem {
  core::Origin origin;
  std::string_view name;
  std::size_t before = 0;  ///< so many come before it
  std::size_t all = 0;
};

template <class Things>
InSystem element_in(const Things& things, std::size_t index) {
  InSystem out{.origin = things.at(index).origin, .name = things.at(index).name};
  for (std::size_t i = 0; i < things.size(); ++i) {
    if (things[i].origin != out.origin) continue;
    if (i < index) ++out.before;
    ++out.all;
  }
  return out;
}

InSystem element_of(const core::System& system, LearnPatch::Element element, std::size_t index) {
  switch (element) {
    case LearnPatch::Element::channel:
      return element_in(system.channels, index);
    case LearnPatch::Element::publisher:
      return element_in(system.publishers, index);
    case LearnPatch::Element::gateway:
      return element_in(system.gateways, index);
    case LearnPatch::Element::network:
      break;
  }
  return element_in(system.networks, index);
}

/// Which of `nodes`, of one name and line, the element is; nullptr if that cannot be told.
const Node* told_apart(const Markup& markup, const std::vector<const Node*>& nodes,
                       const InSystem& one) {
  if (nodes.size() == 1) return nodes.front();
  // The parts of a system are in the order of their elements.
  if (nodes.size() != one.all) return nullptr;
  const Node* const node = nodes[one.before];
  const auto* const name = node->attribute("name");
  return name == nullptr || markup.text_of(*name) == one.name ? node : nullptr;
}

/// The beginning of the line with the end tag if only blanks precede the tag, else the position of
/// the tag.
std::size_t before_end_tag(const Markup& markup, const Node& node) {
  const std::string& text = markup.text();
  std::size_t at = node.content.to;
  while (at > node.content.from && (text[at - 1] == ' ' || text[at - 1] == '\t')) --at;
  return at > 0 && text[at - 1] == '\n' ? at : node.content.to;
}

std::string_view name_of_element(LearnPatch::Element element) {
  constexpr std::array<std::string_view, 4> names = {"EventChannel", "Publisher", "Gateway",
                                                     "Network"};
  return names.at(static_cast<std::size_t>(element));
}

/// Of values of one attribute, the one that all of them need.
std::uint64_t needed(std::string_view key, std::uint64_t one, std::uint64_t other) {
  return key == "period" ? std::min(one, other) : std::max(one, other);
}

}  // namespace

void LearnPatch::state(const Stated& attribute, std::uint64_t value) {
  const auto [there, fresh] = values_.try_emplace(attribute, value);
  if (!fresh) there->second = needed(attribute.key, there->second, value);
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

Result<const Node*> LearnPatch::node_of(Element element, std::size_t index) {
  const InSystem one = element_of(system_, element, index);
  const auto markup = markup_of(one.origin.file);
  if (!markup) return std::unexpected(markup.error());
  const std::string& path = system_.files[one.origin.file];
  const std::string_view name = name_of_element(element);
  std::vector<const Node*> nodes;
  add_elements_at((*markup)->root(), name, one.origin.line, nodes);
  if (nodes.empty())
    return fail(fmt::format("{}: no <{}> begins in line {} any more", path, name, one.origin.line));
  const Node* const node = told_apart(**markup, nodes, one);
  if (node == nullptr) {
    std::string note = fmt::format(
        "{}:{}: several <{}> begin in this line, and which one {} is cannot be told: it is left as "
        "it is; put each on a line of its own",
        path, one.origin.line, name, one.name);
    if (std::ranges::find(notes_, note) == notes_.end()) notes_.push_back(std::move(note));
  }
  return node;
}

std::optional<std::size_t> LearnPatch::channel_of(const Stated& attribute) const {
  if (attribute.element == Element::channel) return attribute.index;
  if (attribute.element == Element::publisher) return system_.publishers[attribute.index].channel;
  return std::nullopt;
}

/// The values by element and attribute. Several parts of a system can have one element.
Result<std::map<std::pair<LearnPatch::At, std::string_view>, LearnPatch::Found>>
LearnPatch::found_values() {
  std::map<std::pair<At, std::string_view>, Found> out;
  for (const auto& [attribute, value] : values_) {
    const auto node = node_of(attribute.element, attribute.index);
    if (!node) return std::unexpected(node.error());
    if (*node == nullptr) continue;
    const std::string& path =
        system_.files[element_of(system_, attribute.element, attribute.index).origin.file];
    const auto [there, fresh] =
        out.try_emplace({{path, (*node)->whole.from}, attribute.key},
                        Found{*node, attribute.element, value, channel_of(attribute)});
    if (!fresh) there->second.value = needed(attribute.key, there->second.value, value);
  }
  return out;
}

/// Before the end tag of an element.
void LearnPatch::insert(const std::string& path, const Node& node, const std::string& text,
                        Changes& to) {
  to.insertions[path].push_back({before_end_tag(markups_.at(path), node), text});
}

Result<void> LearnPatch::insert_in_networks(Changes& to) {
  for (const auto& [network, text] : in_networks_) {
    const auto node = node_of(Element::network, network);
    if (!node) return std::unexpected(node.error());
    if (*node != nullptr)
      insert(system_.files[system_.networks[network].origin.file], **node, text, to);
  }
  return {};
}

Result<const Node*> LearnPatch::system() {
  const auto markup = markup_of(0);
  if (!markup) return std::unexpected(markup.error());
  const std::string& path = system_.files.front();
  const Node& root = (*markup)->root();
  if (root.name != "System") return fail(path + ": the root is no <System> any more");
  if (!root.has_end_tag)
    return fail(
        fmt::format("{}:{}: <System/> has no end tag to put elements before", path, root.line));
  return &root;
}

Result<void> LearnPatch::can_change() {
  for (std::uint32_t file = 0; file < system_.files.size(); ++file)
    if (const auto markup = markup_of(file); !markup) return std::unexpected(markup.error());
  const auto root = system();
  return root ? Result<void>{} : std::unexpected(root.error());
}

Result<void> LearnPatch::insert_at_end(Changes& to) {
  if (in_system_.empty()) return {};
  const auto root = system();
  if (!root) return std::unexpected(root.error());
  insert(system_.files.front(), **root, in_system_, to);
  return {};
}

bool LearnPatch::change(const At& at, std::string_view key, const Found& found, Changes& to) {
  const Node& node = *found.node;
  const bool provides = found.element == Element::gateway || found.element == Element::network;
  const std::string_view name = provides ? "Provision" : "Attributes";
  const std::string words =
      key == "maxPayload" ? std::to_string(found.value) : time_words(found.value);
  const std::string fresh = fmt::format(" {}=\"{}\"", key, words);
  const Node* const list = node.child(name);
  if (list == nullptr) {
    if (found.element != Element::publisher) return false;
    auto& [of, attributes] = to.lists[at];
    of = &node;
    attributes += fresh;
    return true;
  }
  if (!list->children.empty() || std::ranges::count(node.children, name, &Node::name) > 1)
    return false;
  auto& all = to.insertions[at.first];
  if (const auto* const there = list->attribute(key); there != nullptr)
    all.push_back({there->value.from, words, there->value.to - there->value.from});
  else
    all.push_back({list->start_tag.from + 1 + list->name.size(), fresh});
  return true;
}

/// Publishers that state nothing of their own get a list.
void LearnPatch::add_lists(Changes& to) {
  for (const auto& [at, publisher] : to.lists) {
    const auto& [node, attributes] = publisher;
    const Markup& markup = markups_.at(at.first);
    const std::string& text = markup.text();
    const std::string end = std::string(markup.newline()) + indentation(text, node->whole.from);
    const std::string list = fmt::format("{}{}<Attributes{}/>", end, step(markup), attributes);
    auto& all = to.insertions[at.first];
    if (node->has_end_tag) {
      all.push_back({node->content.from, list});
      continue;
    }
    const auto slash = text.rfind('/', node->start_tag.to - 1);
    all.push_back({slash, fmt::format(">{}{}</Publisher>", list, end), node->start_tag.to - slash});
  }
}

Result<void> LearnPatch::replace_comment(std::size_t channel, const std::string& words,
                                         Changes& to) {
  constexpr std::string_view begin = "<!--";
  constexpr std::string_view end = "-->";
  const auto node = node_of(Element::channel, channel);
  if (!node) return std::unexpected(node.error());
  if (*node == nullptr) return {};
  const std::string& path = system_.files[system_.channels[channel].origin.file];
  const auto before = std::string_view(markups_.at(path).text()).substr(0, (*node)->whole.from);
  const auto last = before.find_last_not_of(" \t\r\n");
  if (last == std::string_view::npos || !before.substr(0, last + 1).ends_with(end)) return {};
  const auto first = before.rfind(begin);
  if (first == std::string_view::npos) return {};
  const auto comment = before.substr(first, last + 1 - first);
  if (learn::says_what_was_seen(comment))
    to.insertions[path].push_back(
        {first, fmt::format("<!-- {}; values were changed for this -->", words), comment.size()});
  return {};
}

Result<LearnPatch::Changes> LearnPatch::changes() {
  Changes out;
  notes_.clear();
  const auto found = found_values();
  if (!found) return std::unexpected(found.error());
  std::set<std::size_t> channels;
  for (const auto& [attribute, value] : *found)
    if (change(attribute.first, attribute.second, value, out) && value.channel)
      channels.insert(*value.channel);
  for (const auto& [channel, words] : seen_)
    if (channels.contains(channel))
      if (const auto made = replace_comment(channel, words, out); !made)
        return std::unexpected(made.error());
  add_lists(out);
  if (const auto made = insert_at_end(out); !made) return std::unexpected(made.error());
  if (const auto made = insert_in_networks(out); !made) return std::unexpected(made.error());
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
