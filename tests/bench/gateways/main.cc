// SPDX-License-Identifier: BSD-2-Clause
// Several gateways on one real etcd with TLS and roles, which keeps its data in memory. Root; some
// minutes. Run beside the programs of the build.
// usage: gateways_bench FOLDER [admission|many|forwarder]
//   FOLDER      on the disk on which a journal is measured
//   GATEWAYS=, RESERVATIONS=, CAUGHT_UP=   of `many`: how many, of each, and of the System that a
//               real gateway catches up with (1000, 100, 100000)
#include <fmt/core.h>

#include <cstdio>
#include <exception>
#include <string>

#include "tests/bench/gateways/parts.hpp"

int main(int argc, char** argv) try {
  if (argc < 2) {
    fmt::print(stderr, "usage: {} FOLDER [admission|many|forwarder]\n", argv[0]);
    return 2;
  }
  const std::string part = argc > 2 ? argv[2] : "";
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const auto start = mlcca::bench::Steady::now();
  mlcca::bench::enter_place();
  if (part.empty() || part == "admission") mlcca::bench::measure_admission(argv[1]);
  if (part.empty() || part == "many") mlcca::bench::measure_many();
  if (part.empty() || part == "forwarder") mlcca::bench::measure_forwarder();
  fmt::print("all of this took {:.0f} s\n", mlcca::bench::ms_since(start) / 1000);
  return 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "{}\n", error.what());
  return 1;
}
