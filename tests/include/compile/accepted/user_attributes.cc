// SPDX-License-Identifier: BSD-2-Clause
// Several attributes of the user's own, in every list in another order, and of either end.
#include "mlcca/static_check.hpp"

using namespace mlcca::literals;

template <mlcca::Value V>
struct Temperature
    : mlcca::UserAttribute<Temperature, V, mlcca::Better::smaller, mlcca::Composition::slowest> {};
template <mlcca::Value V>
struct Wear : mlcca::UserAttribute<Wear, V, mlcca::Better::larger, mlcca::Composition::smallest> {};
template <mlcca::Value V>
struct Hops : mlcca::UserAttribute<Hops, V, mlcca::Better::smaller, mlcca::Composition::sum> {};

using Publisher = mlcca::AttributeList<Temperature<280>, mlcca::Omission<2>, Wear<3>>;
using Subscriber =
    mlcca::AttributeList<Hops<3>, Wear<4>, mlcca::MaxPayload<8_bytes>, Temperature<290>>;
using Both = mlcca::Union<Publisher, Subscriber>;

using Can = mlcca::AttributeList<Wear<4>, mlcca::MaxPayload<8_bytes>, Hops<1>, mlcca::Omission<0>,
                                 Temperature<280>>;
using Mesh = mlcca::AttributeList<mlcca::Omission<1>, Hops<2>, Temperature<270>,
                                  mlcca::MaxPayload<64_bytes>, mlcca::Dynamic<Wear<5>>>;
using Pc = mlcca::AttributeList<Hops<0>, mlcca::Omission<0>>;

using layer = mlcca::Check<Both, Can>;
using route = mlcca::CheckRoute<
    Both, mlcca::RouteOf<mlcca::Network<Can>, mlcca::Gateway<Pc>, mlcca::Network<Mesh>>>;
using back = mlcca::CheckRoute<
    Both, mlcca::RouteOf<mlcca::Network<Mesh>, mlcca::Gateway<Pc>, mlcca::Network<Can>>>;
using of_the_publisher = mlcca::Check<mlcca::Union<Publisher, mlcca::AttributeList<>>, Can>;
using of_the_subscriber = mlcca::Check<mlcca::Union<mlcca::AttributeList<>, Subscriber>, Can>;
static_assert(mlcca::Check<Both, Can>::value, "");

// The same name in another place is another attribute.
namespace other {
template <mlcca::Value V>
struct Wear : mlcca::UserAttribute<Wear, V, mlcca::Better::smaller, mlcca::Composition::sum> {};
}  // namespace other
using two_wears = mlcca::Check<mlcca::AttributeList<other::Wear<1>, Wear<9>>,
                               mlcca::AttributeList<Wear<9>, other::Wear<1>>>;
