#include "tools/calibrate/range_choice.hpp"

namespace lcmslam {

RangeChoice choose_range_error(const DepthError& base, const RangeErrorFit& fit) {
  return {base.is_zero() ? fit.error : fit.error, {}};
}

}  // namespace lcmslam
