// SPDX-License-Identifier: BSD-2-Clause
// DBC files: what they say of messages, nodes and the bus, and the network that it becomes.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "tools/design/import/network.hpp"

namespace mlcca::tools::design {

/// Of a value that an attribute states, as the file has it: a number, or a text.
using DbcValue = std::optional<std::string>;

struct DbcMessage {
  std::uint32_t id = 0;  ///< with bit 31 of extended ones
  std::string name;
  std::uint32_t bytes = 0;
  int line = 0;
  std::string comment;
  std::vector<std::size_t> senders;    ///< indices into DbcFile::nodes
  std::vector<std::size_t> receivers;  ///< each once
  std::size_t signals = 0;
  bool multiplexed = false;
  DbcValue cycle, fast, signal_cycle, delay, send_type, format, long_name;
};

struct DbcNode {
  std::string name;
  std::string comment;
  DbcValue address, long_name;
};

struct DbcFile {
  std::vector<DbcNode> nodes;
  std::vector<DbcMessage> messages;
  DbcValue bus_type, baudrate, data_baudrate, protocol;
  Lacks lacks;
};

/// What the text of a DBC file states. `file` is its name in errors: "FILE:LINE: what is wrong".
Result<DbcFile> read_dbc(std::string_view text, const std::string& file);

/// What an ENUM states, and what it is by default, are resolved.
Result<ImportedNetwork> import_dbc(std::string_view text, const std::string& file,
                                   const ImportOptions& options);

}  // namespace mlcca::tools::design
