// SPDX-License-Identifier: BSD-2-Clause
// How far an offered payload is from what a subscriber accepts, in words.
#include <gtest/gtest.h>

#include "core/model/text.hpp"
#include "mlcca/satisfies.hpp"

namespace mlcca::core {
namespace {

std::string margin(Against against, Value required, Value provided) {
  Row row;
  row.against = against;
  row.comparison = compare(Attribute::max_payload, required,
                           AttributeSet{}.set(Attribute::max_payload, provided));
  return format_margin(System{}, row);
}

TEST(PayloadMargin, OfAPublisherIsUpToWhatIsAccepted) {
  EXPECT_EQ(margin(Against::traffic, 8, 100), "92 bytes too long");
  EXPECT_EQ(margin(Against::traffic, 8, 8), "exactly met");
  EXPECT_EQ(margin(Against::traffic, 8, 5), "3 bytes to spare");
}

TEST(PayloadMargin, OfARouteIsDownToWhatIsSent) {
  EXPECT_EQ(margin(Against::end_to_end, 8, 100), "92 bytes to spare");
  EXPECT_EQ(margin(Against::hop, 8, 5), "3 bytes short");
}

}  // namespace
}  // namespace mlcca::core
