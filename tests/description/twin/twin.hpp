// SPDX-License-Identifier: BSD-2-Clause
// Runs description/check.xsl by xsltproc, and says the findings of both checkers in the same form.
#pragma once
#include <compare>
#include <set>
#include <string>
#include <vector>

#include "core/model/system.hpp"

namespace mlcca::testing {

/// What a finding is about. Parts that do not apply are empty.
struct Key {
  std::string id;  ///< "MLCCA021"
  std::string publisher;
  std::string subscriber;
  std::string hop;
  std::string attribute;
  std::string required;  ///< a value
  std::string provided;  ///< a value, "unbounded" or "not provided"
  std::string network;   ///< of a note about a port, whose gateway is `hop`

  auto operator<=>(const Key&) const = default;
};
using Keys = std::set<Key>;

/// Of what is hardly meant: it refuses nothing.
[[nodiscard]] inline bool is_note(const Key& key) {
  return key.id >= "MLCCA038" && key.id <= "MLCCA041";
}

/// "MLCCA021 publisher subscriber hop attribute (required, provided)", for messages.
std::string to_string(const Key& key);

/// Standard output of a shell command; fails the test where that ends with another status than 0.
std::string output_of(const std::string& command);

/// A folder below the temporary one, removed with what is in it.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder(Folder&&) = delete;
  Folder& operator=(const Folder&) = delete;
  Folder& operator=(Folder&&) = delete;

  /// Writes a file and returns its path.
  [[nodiscard]] std::string add(const std::string& name, const std::string& text) const;

 private:
  std::string path_;
};

/// The findings of check.xsl for each of the files, many in one process, with values as numbers.
/// Fails the test where the output is not what check.xsl documents.
std::vector<Keys> twin_findings(const std::vector<std::string>& files);

/// What check.xsl leaves open for each of the files: "PUBLISHER SUBSCRIBER" of each note that names
/// both. Fails the test where an output lacks the note that is of every description.
std::vector<std::set<std::string>> twin_left(const std::vector<std::string>& files);

/// Those of the C++ checker that the twin knows: MLCCA010, 020 and 021, with values for people, and
/// the notes MLCCA038 to 041.
Keys findings_of(core::System system);

/// The twin's findings with values for people.
Keys in_words(const core::System& system, const Keys& keys);

}  // namespace mlcca::testing
