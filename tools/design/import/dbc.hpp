// SPDX-License-Identifier: BSD-2-Clause
// Reads DBC files (messages, nodes and the bus) and converts them into a network.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "tools/design/import/network.hpp"

namespace mlcca::tools::design {

/// The value of a DBC attribute as the file states it, a number or a text; nullopt if there is
/// none.
using DbcValue = std::optional<std::string>;

/// The values of an attribute of the signals of a message.
struct DbcSignalValues {
  std::set<std::string> different;
  std::size_t stated = 0;  ///< number of signals for which the file states one
};

/// A message (BO_) with its comment and attributes.
struct DbcMessage {
  std::uint32_t id = 0;  ///< bit 31 marks an extended identifier
  std::string name;
  std::uint32_t bytes = 0;
  int line = 0;
  std::string comment;
  std::vector<std::size_t> senders;    ///< indices into DbcFile::nodes
  std::vector<std::size_t> receivers;  ///< without duplicates
  std::size_t signals = 0;
  bool multiplexed = false;
  DbcValue cycle, fast, delay, send_type, format, long_name;
  DbcSignalValues signal_cycles, signal_fast, signal_send_types;
};

/// A node (BU_) with its comment and attributes.
struct DbcNode {
  std::string name;
  std::string comment;
  DbcValue address, long_name;
  int address_line = 0;  ///< of the statement; 0: the address is not stated, or a default
};

/// The content of a file; `lacks` lists what was not understood.
struct DbcFile {
  std::vector<DbcNode> nodes;
  std::vector<DbcMessage> messages;
  DbcValue bus_type, baudrate, data_baudrate, protocol;
  Lacks lacks;
};

/// Parses a DBC file. `file` is its name in errors: "FILE:LINE: what is wrong".
Result<DbcFile> read_dbc(std::string_view text, const std::string& file);

/// Parses and converts a DBC file. Values of ENUM attributes and default values are resolved.
Result<ImportedNetwork> import_dbc(std::string_view text, const std::string& file,
                                   const ImportOptions& options);

}  // namespace mlcca::tools::design
