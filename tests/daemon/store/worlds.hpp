// SPDX-License-Identifier: BSD-2-Clause
// Entries to put into a journal, and what must then be in it: by a model that is not the code.
#pragma once
#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/store/journal.hpp"

namespace mlcca::store::test {

/// A directory of a test's own, removed with it.
class Folder {
 public:
  Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  Folder(Folder&&) = delete;
  Folder& operator=(Folder&&) = delete;
  ~Folder();

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

std::string read_file(const std::string& path);
void write_file(const std::string& path, std::string_view bytes);

/// An admission of `channel` under an id.
Admitted admitted(std::uint64_t id, const std::string& channel = "video");

using Batch = std::vector<Entry>;

/// Batches that admit, remove, release, reinstate and grant, each of which changes something, with
/// the contents after each of them; in front the empty contents.
struct Story {
  std::vector<Batch> batches;
  std::vector<Contents> states;
};
/// `largest`: characters of the longest text.
Story random_story(std::uint32_t seed, std::size_t batches, std::size_t largest = 200);

/// Appends and commits; whether that was done.
Result<void> write(Journal& journal, const Batch& batch);

/// For messages of assertions.
std::string text_of(const Contents& contents);

}  // namespace mlcca::store::test
