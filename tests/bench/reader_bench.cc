// SPDX-License-Identifier: BSD-2-Clause
// The reader of descriptions against libxml2 over the same file in the same process, in turns: its
// bare streaming parse (what `xmllint --stream --noout` does: the floor), the same with its schema
// validator, and ours: parse and grammar; all of examine(). Usage: reader_bench FILE [ROUNDS]
#include <fmt/format.h>
#include <libxml/xmlreader.h>
#include <libxml/xmlschemas.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "description/problems.hpp"
#include "description/read.hpp"
#include "description/xml.hpp"

namespace {

using namespace mlcca;

void require(bool good, const char* what) {
  if (!good) throw std::runtime_error(what);
}

void stream(const std::string& path, xmlSchema* schema) {
  const std::unique_ptr<xmlTextReader, FreeWith<xmlFreeTextReader>> reader(
      xmlReaderForFile(path.c_str(), nullptr, XML_PARSE_NONET));
  require(reader != nullptr, "cannot open the file");
  if (schema != nullptr) xmlTextReaderSetSchema(reader.get(), schema);
  while (xmlTextReaderRead(reader.get()) == 1) {
  }
  require(schema == nullptr || xmlTextReaderIsValid(reader.get()) == 1, "not valid");
}

void parse(const std::string& path) {
  description::Problems problems(path);
  require(parse_files(std::span(&path, 1), description::Root::system, problems, {}, {}),
          "not valid");
}

void examine(const std::string& path) {
  require(description::examine({path}).problems.empty(), "not without problems");
}

template <class Work>
double seconds(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 2) {
    fmt::print(stderr, "usage: {} FILE [ROUNDS]\n", argv[0]);
    return 2;
  }
  const std::string path = argv[1];
  const int rounds = argc > 2 ? std::atoi(argv[2]) : 5;
  const std::unique_ptr<xmlSchemaParserCtxt, FreeWith<xmlSchemaFreeParserCtxt>> parser(
      xmlSchemaNewMemParserCtxt(description::schema().data(),
                                static_cast<int>(description::schema().size())));
  const std::unique_ptr<xmlSchema, FreeWith<xmlSchemaFree>> schema(xmlSchemaParse(parser.get()));
  require(schema != nullptr, "the schema cannot be read");

  constexpr double kNever = std::numeric_limits<double>::max();
  double floor = kNever;
  double validated = kNever;
  double parsed = kNever;
  double examined = kNever;
  for (int i = 0; i < rounds; ++i) {
    floor = std::min(floor, seconds([&] { stream(path, nullptr); }));
    validated = std::min(validated, seconds([&] { stream(path, schema.get()); }));
    parsed = std::min(parsed, seconds([&] { parse(path); }));
    examined = std::min(examined, seconds([&] { examine(path); }));
  }
  const auto row = [&](const char* what, double time) {
    fmt::print("{:42} {:9.1f} ms   ratio {:.2f}\n", what, time * 1e3, time / floor);
  };
  row("libxml2, streaming parse (the floor)", floor);
  row("libxml2, streaming parse and validator", validated);
  row("ours, parse and grammar", parsed);
  row("ours, up to names and rules (examine)", examined);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  fmt::print("{:42} {:9.1f} MiB\n", "most memory of all of these",
             static_cast<double>(usage.ru_maxrss) / 1024);
  return 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "reader_bench: {}\n", error.what());
  return 1;
}
