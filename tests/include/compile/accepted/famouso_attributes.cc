// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO: every attribute by its name and in its unit.
#include "AttributeList.h"
#include "Bandwidth.h"
#include "CheckAttributeAgainstAttributeList.h"
#include "Deadline.h"
#include "Jitter.h"
#include "Latency.h"
#include "MaxEventLength.h"
#include "MaxPayload.h"
#include "Omission.h"
#include "PacketLoss.h"
#include "Period.h"
#include "RelativeDeadline.h"
#include "Throughput.h"

using Everything = AttributeList<Latency<100>, Jitter<5>, Deadline<3>, Period<50>, Bandwidth<310>,
                                 PacketLoss<1498>, Omission<10>, MaxPayload<8>>::type;
using mlcca::Attribute;
static_assert(Everything::set()[Attribute::latency] == 100000, "us");
static_assert(Everything::set()[Attribute::jitter] == 5000, "us");
static_assert(Everything::set()[Attribute::deadline] == 3000000, "ms");
static_assert(Everything::set()[Attribute::period] == 50000000, "ms");
static_assert(Everything::set()[Attribute::bandwidth] == 310, "bytes/s");
static_assert(Everything::set()[Attribute::packet_loss] == 149800000, "14.98 %");
static_assert(Everything::set()[Attribute::omission] == 10, "events");
static_assert(Everything::set()[Attribute::max_payload] == 8, "bytes");
static_assert(AttributeList<RelativeDeadline<3>>::type::set()[Attribute::deadline] == 3000, "us");
static_assert(AttributeList<Throughput<9>>::type::set()[Attribute::bandwidth] == 9, "bytes/s");
static_assert(AttributeList<MaxEventLength<9>>::type::set()[Attribute::max_payload] == 9, "bytes");

template <class Provided>
using Test = typename CheckAttributeAgainstAttributeList<Everything, Provided>::type;
typedef Test<Latency<100>> latency;
typedef Test<Deadline<3>> deadline;
typedef Test<Throughput<310>> larger_is_better;
typedef Test<MaxPayload<9>> larger_is_better_too;
typedef Test<Everything> list;
typedef CheckAttributeAgainstAttributeList<AttributeList<Omission<2>>, Period<70>>::type
    not_asked_for;
latency unused;
