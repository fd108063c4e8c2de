// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/described.hpp"

#include <fmt/core.h>
#include <malloc.h>
#include <unistd.h>

#include <array>
#include <utility>

#include "core/model/text.hpp"
#include "description/kinds.hpp"
#include "description/read.hpp"

namespace mlcca {
namespace {

std::string host_name() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) < 0) return {};
  return name.data();
}

std::expected<std::size_t, std::string> find_self(const core::System& system,
                                                  const std::string& name) {
  const std::string host = host_name();
  std::string known;
  for (std::size_t g = 0; g < system.gateways.size(); ++g) {
    if (name.empty() ? system.gateways[g].host == host : system.gateways[g].name == name) return g;
    known += (known.empty() ? "" : ", ") + system.gateways[g].name;
  }
  if (name.empty() && system.gateways.size() == 1) return 0;
  if (name.empty())
    return std::unexpected(
        fmt::format("no gateway of the description has the host '{}': say which one this is with "
                    "--gateway ({})",
                    host, known.empty() ? "it has none" : known));
  return std::unexpected(fmt::format("no gateway of the description is called '{}' (there are: {})",
                                     name, known.empty() ? "none" : known));
}

DescribedResult taken_up(const Options& options, const std::string& name,
                         description::Description system, const Sha256::Digest& digest) {
  if (!system) {
    StartError refused{.lines = {}, .bad_input = true};
    for (const auto& problem : description::shortened(system.error())) {
      refused.lines.push_back(description::to_string(problem));
      if (problem.id == core::FindingId::unreadable) refused.bad_input = false;
    }
    return std::unexpected(std::move(refused));
  }
  const auto self = find_self(*system, options.gateway);
  if (!self) return std::unexpected(StartError{{name + ": " + self.error()}, true});
  Described described{
      .state = std::make_unique<core::State>(std::move(*system)), .self = *self, .digest = digest};
  ::malloc_trim(0);  // reading leaves several times the memory of the description behind
  return described;
}  // NOLINT(clang-analyzer-cplusplus.NewDeleteLeaks): the state moves with what is returned

}  // namespace

DescribedResult read_description(const Options& options) {
  Sha256::Digest digest{};
  std::string text;
  auto system = description::read(options.description, description::Users::of_this_machine,
                                  options.in_cluster ? &digest : nullptr,
                                  options.in_cluster ? &text : nullptr);
  auto described = taken_up(options, options.description, std::move(system), digest);
  if (described) described->text = std::move(text);
  return described;
}

DescribedResult read_description_text(const Options& options, const std::string& text) {
  Sha256::Digest digest{};
  auto system = description::read_bundle(text, description::Users::of_this_machine, digest);
  return taken_up(options, "the description of the cluster", std::move(system), digest);
}

std::string not_read_in_time(const Options& options) {
  return fmt::format(
      "{} could not be read within {}: does a look-up of users hang, or a file system?",
      options.description, core::format_value(Attribute::latency, options.read_limit_ns));
}

}  // namespace mlcca
