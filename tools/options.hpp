// SPDX-License-Identifier: BSD-2-Clause
// The command line: which verb, its arguments, and how to talk and print.
#pragma once
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "control/messages.hpp"
#include "core/result.hpp"
#include "tools/exit.hpp"
#include "tools/table.hpp"

namespace mlcca::tools {

/// Arguments of all verbs; each takes the ones that its Takes names.
struct Arguments {
  std::string channel;
  std::string from;
  std::string to;
  std::vector<std::string> require;
  std::vector<std::string> offer;
  std::optional<std::uint32_t> node;
  std::optional<std::uint32_t> priority;
  std::string user;
  std::string subscriber;
  std::string publisher;
  std::optional<std::uint64_t> admission;
  std::string mode;
};

enum class Takes : std::uint8_t {
  nothing,
  channel,
  delivery,   ///< a channel, and the ends that shall be added to it
  admission,  ///< a channel, or the id of an admission
  mode,
};

struct Options {
  std::string socket;
  bool json = false;
  Color color = Color::no;  ///< of standard output
  Color error_color = Color::no;
  std::chrono::milliseconds patience{};
};

struct Verb {
  const char* name;
  const char* help;
  Takes takes;
  Exit (*run)(const Options& options, const Arguments& arguments);
};

/// A command line that is to be carried out.
struct Command {
  const Verb* verb = nullptr;
  Options options;
  Arguments arguments;
};

/// The command, or how to exit because everything has been said: help, version, or what is wrong.
std::variant<Command, Exit> parse(std::span<const Verb> verbs, int argc, const char* const* argv);

/// The message that query and admit send.
Result<control::ChannelRequest> delivery(const Arguments& from);

}  // namespace mlcca::tools
