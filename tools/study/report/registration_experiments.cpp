// The experiments on registration, in the thesis's order.

#include "tools/study/report/experiment.hpp"

namespace lcmslam {

std::vector<Experiment> registration_experiments() {
  return {};
}

}  // namespace lcmslam
