// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/learn_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <csignal>
#include <ranges>
#include <span>

#include "core/model/words.hpp"
#include "core/profiles/profile.hpp"
#include "description/values.hpp"
#include "tools/values.hpp"

namespace mlcca::tools::design {
namespace {

auto twice(const char* option, const std::string& text, const std::string& interface) {
  return fail(fmt::format("{} {}: the option names {} twice", option, text, interface));
}

}  // namespace

std::optional<std::pair<std::string, std::string>> assignment(const std::string& text) {
  const auto at = text.find('=');
  if (at == std::string::npos || at == 0) return std::nullopt;
  return std::pair(text.substr(0, at), text.substr(at + 1));
}

Result<std::map<std::string, std::uint32_t>> stated_rates(const std::vector<std::string>& texts,
                                                          const char* option, std::uint32_t most) {
  std::map<std::string, std::uint32_t> out;
  for (const std::string& text : texts) {
    const auto parts = assignment(text);
    const auto rate = parts ? parse_bus_rate(parts->second, most)
                            : Result<std::uint32_t>(fail("write can0=500k"));
    if (!rate) return fail(fmt::format("{} {}: {}", option, text, rate.error().text));
    if (!out.try_emplace(parts->first, *rate).second) return twice(option, text, parts->first);
  }
  return out;
}

Result<std::map<std::string, core::Profile>> stated_profiles(
    const std::vector<std::string>& texts) {
  std::map<std::string, core::Profile> out;
  for (const std::string& text : texts) {
    const auto parts = assignment(text);
    const auto profile = parts ? core::words::kProfiles.find(parts->second) : std::nullopt;
    if (!profile || !core::names_channels(*profile))
      return fail(fmt::format("--profile {}: write an interface and one of {}, such as can0=j1939",
                              text, fmt::join(std::span(core::words::kProfiles).subspan(1), ", ")));
    if (!out.try_emplace(parts->first, *profile).second)
      return twice("--profile", text, parts->first);
  }
  return out;
}

Result<void> fit_interfaces(const std::vector<std::string>& texts, const char* option,
                            bool of_buses, const std::map<std::string, learn::Medium>& there) {
  for (const std::string& text : texts) {
    const auto parts = assignment(text);
    if (!parts) continue;
    const auto interface = there.find(parts->first);
    if (interface == there.end())
      return fail(fmt::format("{} {}: there is no interface {}: {}", option, text, parts->first,
                              fmt::join(std::views::keys(there), ", ")));
    if (of_buses && interface->second == learn::Medium::ethernet)
      return fail(fmt::format("{} {}: {} is no CAN bus", option, text, parts->first));
  }
  return {};
}

Result<void> can_be_user(const std::string& name) {
  const auto& type = description::type::kUserName;
  if (description::is_valid(type, name)) return {};
  return fail(fmt::format("--user {}: {}", name, description::explain(type, name)));
}

void on_end(void (*handler)(int)) {
  struct sigaction action{};
  action.sa_handler = handler;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  struct sigaction before{};
  ::sigaction(SIGHUP, nullptr, &before);
  if (before.sa_handler != SIG_IGN) ::sigaction(SIGHUP, &action, nullptr);
}

}  // namespace mlcca::tools::design
