// SPDX-License-Identifier: BSD-2-Clause
// Which row of a verdict a person is told of, and how long a reaction takes at most.
#include "core/model/verdict.hpp"

#include <gtest/gtest.h>

#include <initializer_list>

#include "mlcca/check.hpp"

namespace mlcca::core {
namespace {

constexpr Place kHere{Place::Kind::network, 0};
constexpr Place kThere{Place::Kind::network, 1};

Row row(Attribute attribute, Value required, Value provided, Against against = Against::end_to_end,
        Place place = kHere) {
  Row out{.place = place, .against = against};
  out.comparison = compare(attribute, required, AttributeSet{}.set(attribute, provided));
  return out;
}

Verdict granted(std::initializer_list<Row> rows) {
  Verdict v;
  v.granted = true;
  v.rows = rows;
  return v;
}
Verdict refused(std::initializer_list<Row> rows) {
  Verdict v = granted(rows);
  v.granted = false;
  return v;
}

TEST(DecidingRow, OfAGrantIsTheOneWithTheSmallestRelativeMargin) {
  // 10 of 100 ns are left, 1 of 4 events, 1000 of 1100 bytes/s.
  const Verdict v = granted({row(Attribute::omission, 4, 3), row(Attribute::latency, 100, 90),
                             row(Attribute::bandwidth, 100, 1100)});
  EXPECT_EQ(deciding_row(v), &v.rows[1]);
  const Verdict exact = granted({row(Attribute::latency, 100, 90), row(Attribute::omission, 0, 0),
                                 row(Attribute::jitter, 100, 99)});
  EXPECT_EQ(deciding_row(exact), &exact.rows[1]) << "0 of 0 is exactly met";
  const Verdict first = granted({row(Attribute::latency, 10, 5), row(Attribute::jitter, 10, 5)});
  EXPECT_EQ(deciding_row(first), &first.rows[0]) << "of equal ones";
  const Verdict endless =
      granted({row(Attribute::bandwidth, 100, kUnbounded), row(Attribute::latency, 1000, 1)});
  EXPECT_EQ(deciding_row(endless), &endless.rows[1]) << "what has no limit is not near it";
}

TEST(DecidingRow, OfAGrantIsNoHopAndNothingThatIsMetByRule) {
  const Verdict v =
      granted({row(Attribute::latency, 10, 10, Against::hop), row(Attribute::max_payload, 8, 8),
               row(Attribute::period, 5, 5), row(Attribute::omission, 4, 1)});
  EXPECT_EQ(deciding_row(v), &v.rows[3]);
  const Verdict rule = granted({row(Attribute::max_payload, 8, 8), row(Attribute::period, 5, 5)});
  EXPECT_EQ(deciding_row(rule), &rule.rows[0]) << "where there is nothing else";
  EXPECT_EQ(deciding_row(granted({})), nullptr);
  const Verdict slower = granted({row(Attribute::period, 5, 4), row(Attribute::omission, 4, 1)});
  EXPECT_EQ(deciding_row(slower), &slower.rows[0]);
}

TEST(DecidingRow, OfARefusalIsTheFirstThatIsNotFulfilled) {
  const Verdict v =
      refused({row(Attribute::latency, 10, 9, Against::hop),
               row(Attribute::omission, 0, 1, Against::hop, kThere), row(Attribute::jitter, 1, 2)});
  EXPECT_EQ(deciding_row(v), &v.rows[1]);
  EXPECT_EQ(deciding_row(refused({row(Attribute::latency, 10, 9)})), nullptr);
}

TEST(DecidingRow, OfARefusalIsWhatCannotFitBeforeWhatIsNotKnownYet) {
  Row open = row(Attribute::latency, 10, 9, Against::hop);
  open.comparison.outcome = Outcome::run_time;
  const Verdict v = refused({open, row(Attribute::omission, 2, 5, Against::hop)});
  EXPECT_EQ(deciding_row(v), &v.rows[1]);
  const Verdict all_open = refused({open, open});
  EXPECT_EQ(deciding_row(all_open), &all_open.rows[0]);
}

TEST(DecidingRow, WhatAHopCannotGiveIsNotSaidOfTheWholeWay) {
  const Verdict v = refused({row(Attribute::omission, 0, 1), row(Attribute::jitter, 1, 2),
                             row(Attribute::omission, 0, 1, Against::hop)});
  EXPECT_TRUE(is_said_by_another(v, v.rows[0]));
  EXPECT_FALSE(is_said_by_another(v, v.rows[1])) << "of another attribute";
  EXPECT_FALSE(is_said_by_another(v, v.rows[2]));
  EXPECT_EQ(deciding_row(v), &v.rows[1]);
  const Verdict fits =
      refused({row(Attribute::omission, 2, 3), row(Attribute::omission, 2, 1, Against::hop)});
  EXPECT_FALSE(is_said_by_another(fits, fits.rows[0])) << "the hop is good enough";
  Verdict users =
      refused({row(Attribute::omission, 0, 1), row(Attribute::omission, 0, 1, Against::hop)});
  users.rows[0].user = 3;
  users.rows[1].user = 4;
  EXPECT_FALSE(is_said_by_another(users, users.rows[0]));
  users.rows[1].user = 3;
  EXPECT_TRUE(is_said_by_another(users, users.rows[0]));
}

TEST(DecidingRow, WhatAMeshHasLeftSaysMoreThanWhatItGivesToOneAlone) {
  const Row alone = row(Attribute::bandwidth, 10, 5, Against::hop);
  const Row left = row(Attribute::bandwidth, 10, 3, Against::medium_time);
  const Verdict v = refused({alone, left});
  EXPECT_TRUE(is_said_by_another(v, v.rows[0]));
  EXPECT_EQ(deciding_row(v), &v.rows[1]);
  Verdict elsewhere = v;
  elsewhere.rows[1].place = kThere;
  EXPECT_FALSE(is_said_by_another(elsewhere, elsewhere.rows[0]));
  Verdict user = v;
  user.rows[0].user = 1;
  EXPECT_FALSE(is_said_by_another(user, user.rows[0]));
  const Verdict latency = refused({row(Attribute::latency, 10, 50, Against::hop),
                                   row(Attribute::latency, 10, 50, Against::medium_time)});
  EXPECT_FALSE(is_said_by_another(latency, latency.rows[0]));
}

TEST(Reaction, IsTheLastHeartBeatThatMayComeAndItsWay) {
  Verdict v;
  v.requirement.set(Attribute::omission, 2).set(Attribute::period, 50);
  v.provision.set(Attribute::latency, 12).set(Attribute::jitter, 5);
  EXPECT_EQ(worst_case_reaction(v), 3 * 50 + 12 + 5U);
  v.provision.clear(Attribute::jitter);
  EXPECT_EQ(worst_case_reaction(v), 3 * 50 + 12 + 12U) << "at most the latency";
  EXPECT_EQ(reaction_terms(v)[Attribute::jitter], 12U);
  v.provision.clear(Attribute::latency);
  EXPECT_EQ(worst_case_reaction(v), std::nullopt);
  EXPECT_FALSE(reaction_terms(v).has(Attribute::jitter));
}

}  // namespace
}  // namespace mlcca::core
