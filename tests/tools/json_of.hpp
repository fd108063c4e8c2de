// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "control/messages.hpp"
#include "tools/json.hpp"

namespace mlcca::tools {

/// What a program gets of a reply, which is one line.
inline nlohmann::json json_of(const control::Reply& reply) {
  const auto text = to_json(reply);
  EXPECT_EQ(text.find('\n'), text.size() - 1) << "one line";
  return nlohmann::json::parse(text, nullptr, false);
}

}  // namespace mlcca::tools
