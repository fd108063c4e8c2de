// SPDX-License-Identifier: BSD-2-Clause
// The definitions of attributes in DBC files (BA_DEF_, BA_DEF_DEF_), and the attributes that the
// import uses.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/design/import/dbc.hpp"

namespace mlcca::tools::design {

enum class DbcObject : std::uint8_t { network, node, message, signal, other };

/// The meaning of an attribute for the import; none: it is not used.
enum class DbcRole : std::uint8_t {
  none,
  cycle,
  fast,
  signal_cycle,
  signal_fast,
  signal_send_type,
  delay,
  send_type,
  format,
  long_name,
  address,
  bus_type,
  baudrate,
  data_baudrate,
  protocol,
};

/// The role of an attribute, by its name in upper or lower case.
DbcRole role_of(DbcObject object, std::string_view name);

/// Where the message, node or file stores the value with that role; nullptr if it has none.
DbcValue* place_of(DbcMessage& message, DbcRole role);
DbcValue* place_of(DbcNode& node, DbcRole role);
DbcValue* place_of(DbcFile& file, DbcRole role);
/// Where the message stores the values of its signals with that role; nullptr if it has none.
DbcSignalValues* values_of_signals(DbcMessage& message, DbcRole role);

/// The definitions of a file, which give the meaning of numbers and the defaults of attributes.
class DbcDefinitions {
 public:
  /// False if there are too many definitions.
  bool define(DbcObject object, std::string_view name, std::vector<std::string> words);
  /// False if there is no such attribute.
  bool set_default(std::string_view name, const std::string& value);
  /// Replaces the numbers of an ENUM by its words, and sets values that were not stated to the
  /// defaults.
  void complete(DbcFile& file) const;

 private:
  struct Definition {
    std::vector<std::string> words;  ///< the words of an ENUM; empty for other types
    DbcValue otherwise;
  };
  struct Meant {
    DbcRole role;
    const Definition* definition;
  };
  [[nodiscard]] std::vector<Meant> meant(DbcObject object) const;
  void complete(DbcFile& file, DbcObject object) const;
  template <class Where>
  void complete_all(std::vector<Where>& all, DbcObject object) const;
  void complete_signals(DbcFile& file) const;
  static void complete(DbcSignalValues& values, std::size_t signals, const Definition& definition);
  static void complete(DbcValue* value, const Definition& definition);

  std::map<std::pair<DbcObject, std::string>, Definition, std::less<>> definitions_;
};

}  // namespace mlcca::tools::design
