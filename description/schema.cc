// SPDX-License-Identifier: BSD-2-Clause
// The schema, compiled in, so that a program can show it without any file.
#include "description/read.hpp"

namespace mlcca::description {
namespace {

constexpr char kSchema[] =
#include "system_xsd.inc"
    ;

}  // namespace

std::string_view schema() { return {kSchema, sizeof(kSchema) - 1}; }

}  // namespace mlcca::description
