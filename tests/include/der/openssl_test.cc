// SPDX-License-Identifier: BSD-2-Clause
// `openssl asn1parse` reads every encoding that we write, element by element.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <sstream>
#include <string>

#include "tests/include/der/octets.hpp"
#include "tests/include/der/random_channel.hpp"

namespace mlcca::testing {
namespace {

/// A file that is gone with the object.
class File {
 public:
  explicit File(const Octets& octets) {
    const int descriptor = ::mkstemp(path_.data());
    complete_ = descriptor >= 0 && ::write(descriptor, octets.data(), octets.size()) ==
                                       static_cast<ssize_t>(octets.size());
    ::close(descriptor);
  }
  ~File() { ::unlink(path_.c_str()); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  File(File&&) = delete;
  File& operator=(File&&) = delete;

  [[nodiscard]] bool complete() const { return complete_; }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_ = ::testing::TempDir() + "mlcca-der-XXXXXX";
  bool complete_ = false;
};

struct Printed {
  std::string output;
  int status = -1;
};
Printed asn1parse(const Octets& octets) {
  const File file(octets);
  Printed run;
  if (!file.complete()) return run;
  const std::string command = "openssl asn1parse -inform DER -in '" + file.path() + "' 2>&1";
  std::FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return run;
  char buffer[4096];
  for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof buffer, pipe)) != 0;)
    run.output.append(buffer, n);
  run.status = ::pclose(pipe);
  return run;
}

std::size_t count(const std::string& text, std::string_view part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

TEST(OpensslTest, EmergencySwitchIsPrinted) {
  const AttributeSet needs =
      AttributeSet().set(Attribute::period, 50000000).set(Attribute::omission, 2);
  const der::UserAttribute users[] = {{"Temperature", 300}};
  const der::Channel channel(der::Role::subscriber, 0x17, needs, users, 1);
  Octets octets(der::kMaxSize);
  octets.resize(der::encode(channel, octets.data(), octets.size()));
  const Printed run = asn1parse(octets);
  ASSERT_EQ(run.status, 0) << run.output;
  for (const char* part :
       {"INTEGER           :01", "ENUMERATED        :01", "[HEX DUMP]:0000000000000017",
        "cont [ 4 ]", "cont [ 7 ]", "UTF8STRING        :Temperature", "INTEGER           :012C"})
    EXPECT_NE(run.output.find(part), std::string::npos) << part << "\n" << run.output;
}

TEST(OpensslTest, EveryEncodingIsRead) {
  // One after the other in one file: a process for each would take minutes.
  constexpr std::size_t channels = 2000;
  RandomWorld world(21);
  Octets all;
  std::size_t attributes = 0;
  std::size_t users = 0;
  for (std::size_t i = 0; i < channels; ++i) {
    const RandomChannel random(world);
    all = join({all, random.encoded()});
    bool dynamic = false;
    for (std::size_t k = 0; k < kAttributes; ++k) {
      attributes += random.get().attributes.has(attribute_at(k)) ? 1 : 0;
      dynamic = dynamic || random.get().attributes.is_dynamic(attribute_at(k));
    }
    attributes += dynamic ? 1 : 0;
    users += random.get().users;
  }
  const Printed run = asn1parse(all);
  ASSERT_EQ(run.status, 0) << run.output.substr(run.output.size() - 500);
  EXPECT_EQ(count(run.output, ":d=0 "), channels);
  EXPECT_EQ(count(run.output, "prim: cont [ "), attributes);
  EXPECT_EQ(count(run.output, "prim: UTF8STRING"), users);
  EXPECT_EQ(count(run.output, "prim: OCTET STRING"), channels);
}

}  // namespace
}  // namespace mlcca::testing
