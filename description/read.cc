// SPDX-License-Identifier: BSD-2-Clause
// Runs the stages in order: documents, draft, names, rules.
#include "description/read.hpp"

#include <algorithm>
#include <utility>

#include "description/bundle.hpp"
#include "description/draft.hpp"
#include "description/grammar.hpp"
#include "description/problems.hpp"
#include "description/rules.hpp"
#include "description/source.hpp"
#include "description/xml.hpp"

namespace mlcca::description {
namespace {

/// Fills a draft while a description is parsed, then runs the other stages.
class Stages {
 public:
  explicit Stages(std::string name) : problems_(std::move(name)) {}

  [[nodiscard]] Receiver receiver() {
    return {.root = [this](const Element& root) { draft_.name = root.attribute("name"); },
            .part = [this](const Element& part) { add_part(part, draft_, problems_); }};
  }
  Problems& problems() { return problems_; }

  /// `valid`: only values of attributes were wrong so far.
  Examined finish(bool valid, Users users = Users::of_this_machine) {
    Examined out;
    out.readable = valid;
    // Names defined by an invalid part are missing, so that looking up names would report their
    // users as well.
    if (valid) {
      out.system = resolve(std::move(draft_), problems_, users);
      check_rules(out.system, problems_);
    } else {
      out.system.files = problems_.files();
    }
    out.problems = problems_.take();
    return out;
  }

 private:
  Problems problems_;
  Draft draft_;
};

/// The name in the first start tag, after comments and processing instructions; empty if there is
/// none at the start of the text.
std::string_view root_name(std::string_view xml) {
  for (auto at = xml.find('<'); at != std::string_view::npos; at = xml.find('<')) {
    xml.remove_prefix(at + 1);
    const bool comment = xml.starts_with("!--");
    if (!comment && !xml.starts_with('?')) {
      const auto end = xml.find_first_of(" \t\r\n/>");
      return end == std::string_view::npos ? std::string_view{} : xml.substr(0, end);
    }
    const auto end = xml.find(comment ? "-->" : "?>");
    if (end == std::string_view::npos) break;
    xml.remove_prefix(end);
  }
  return {};
}

Description only_without_problems(Examined examined) {
  if (!examined.problems.empty()) return std::unexpected(std::move(examined.problems));
  return std::move(examined.system);
}

}  // namespace

Examined examine(const std::vector<std::string>& paths, const Progress& progress, Users users) {
  Stages stages(paths.front());
  const bool valid =
      parse_files(paths, Root::system, stages.problems(), stages.receiver(), progress);
  return stages.finish(valid, users);
}

bool is_part(const std::string& path) {
  const auto source = Source::open(path);
  if (!source) return false;
  const auto root = root_name(source->start());
  return std::ranges::find(system_parts(), root, &Child::name) != system_parts().end();
}

Description read(const std::string& path, Users users, Sha256::Digest* digest,
                 std::string* bundle) {
  Stages stages(path);
  const bool valid = parse_files(std::span(&path, 1), Root::system, stages.problems(),
                                 stages.receiver(), {}, digest, bundle);
  return only_without_problems(stages.finish(valid, users));
}

Description read_bundle(std::string_view bundle, Users users, Sha256::Digest& digest) {
  const auto files = files_in(bundle);
  Stages stages(files ? std::string(files->front().name) : "the text");
  const bool valid = parse_bundle(bundle, stages.problems(), stages.receiver(), digest);
  return only_without_problems(stages.finish(valid, users));
}

Description read_memory(std::string_view xml, const std::string& name, const std::string& base,
                        Users users) {
  Stages stages(name);
  return only_without_problems(
      stages.finish(parse_text(xml, base, stages.problems(), stages.receiver()), users));
}

std::vector<Problem> check_part(const std::string& path) {
  Problems problems(path);
  parse_files(std::span(&path, 1), Root::system_or_part, problems, {}, {});
  return problems.take();
}

}  // namespace mlcca::description
