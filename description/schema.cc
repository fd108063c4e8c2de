// SPDX-License-Identifier: BSD-2-Clause
// The schema, compiled in: a program shows it without depending on a file next to it.
#include "description/read.hpp"

namespace mlcca::description {
namespace {

constexpr char kSchema[] =
#include "system_xsd.inc"
    ;

}  // namespace

std::string_view schema() { return {kSchema, sizeof(kSchema) - 1}; }

}  // namespace mlcca::description
