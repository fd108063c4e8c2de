// SPDX-License-Identifier: BSD-2-Clause
// Every check with attributes that fit.
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;
using Switch = mlcca::AttributeList<mlcca::Period<50_ms>, mlcca::Omission<2>>;
using Can = mlcca::AttributeList<mlcca::Period<10_ms>, mlcca::Omission<1>>;
using Pc = mlcca::AttributeList<mlcca::Latency<1_ms>, mlcca::Omission<0>>;

template <mlcca::Value V>
struct Temperature
    : mlcca::UserAttribute<Temperature, V, mlcca::Better::smaller, mlcca::Composition::slowest> {};

using Motor = mlcca::AttributeList<mlcca::Period<60_ms>, mlcca::Omission<2>, mlcca::Latency<30_ms>>;
using Mesh = mlcca::AttributeList<mlcca::Period<10_ms>, mlcca::Dynamic<mlcca::Omission<0>>,
                                  mlcca::Latency<15_ms>>;
using Warm = mlcca::AttributeList<Temperature<300>, mlcca::Omission<0>>;
using Both = mlcca::Union<Switch, Motor>;

struct Layer {
  using layer = mlcca::Check<Switch, Can>;
  typedef mlcca::Check<Switch, Can>::type famouso_style;
};
using traffic = mlcca::CheckTraffic<Switch, Motor>;
using route = mlcca::CheckRoute<
    Both, mlcca::RouteOf<mlcca::Network<Can>, mlcca::Gateway<Pc>, mlcca::Network<Mesh>>>;
using user = mlcca::Check<mlcca::AttributeList<Temperature<300>>, Warm>;
static_assert(mlcca::Check<Both, Mesh>::value, "decided at run time");
static_assert(Switch::set()[mlcca::Attribute::period] == mlcca::count(50_ms), "");

template <class Spec>
struct Component {
  using check = mlcca::Check<Spec, Can>;
};
Component<Switch> component;
