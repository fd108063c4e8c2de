// SPDX-License-Identifier: BSD-2-Clause
// Attributes of DBC files: how they are defined, and which of them mean something to us.
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

/// What we make of an attribute.
enum class DbcRole : std::uint8_t {
  none,
  cycle,
  fast,
  signal_cycle,
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

/// Whichever letters are large.
DbcRole role_of(DbcObject object, std::string_view name);

/// Where the message, node or file keeps the value of that role; nullptr: nowhere.
DbcValue* place_of(DbcMessage& message, DbcRole role);
DbcValue* place_of(DbcNode& node, DbcRole role);
DbcValue* place_of(DbcFile& file, DbcRole role);

/// BA_DEF_ and BA_DEF_DEF_ of a file.
class DbcDefinitions {
 public:
  /// False: there are too many.
  bool define(DbcObject object, std::string_view name, std::vector<std::string> words);
  /// False: there is no such attribute.
  bool set_default(std::string_view name, const std::string& value);
  /// Numbers of an ENUM become its words, and what was not stated becomes the default.
  void complete(DbcFile& file) const;

 private:
  struct Definition {
    std::vector<std::string> words;  ///< of an ENUM
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
  static void complete(DbcValue* value, const Definition& definition);

  std::map<std::pair<DbcObject, std::string>, Definition, std::less<>> definitions_;
};

}  // namespace mlcca::tools::design
