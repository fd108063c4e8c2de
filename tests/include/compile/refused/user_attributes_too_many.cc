// SPDX-License-Identifier: BSD-2-Clause
// Seventeen attributes of the user's own in one list.
// expect: static
// expect: an AttributeList has at most 16 attributes of the user's own
// lines: 30
#include "mlcca/static_check.hpp"

template <int N>
struct Number {
  template <mlcca::Value V>
  struct Of : mlcca::UserAttribute<Of, V, mlcca::Better::smaller, mlcca::Composition::sum> {};
};
using Seventeen =
    mlcca::AttributeList<Number<1>::Of<1>, Number<2>::Of<1>, Number<3>::Of<1>, Number<4>::Of<1>,
                         Number<5>::Of<1>, Number<6>::Of<1>, Number<7>::Of<1>, Number<8>::Of<1>,
                         Number<9>::Of<1>, Number<10>::Of<1>, Number<11>::Of<1>, Number<12>::Of<1>,
                         Number<13>::Of<1>, Number<14>::Of<1>, Number<15>::Of<1>, Number<16>::Of<1>,
                         Number<17>::Of<1>>;
using check = mlcca::Check<mlcca::AttributeList<Number<1>::Of<1>>, Seventeen>;
