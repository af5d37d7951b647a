#include <lcmslam/parallel/shared_processors.hpp>

#include <algorithm>
#include <opencv2/core/utility.hpp>

namespace lcmslam {

void share_processors() {
  cv::setNumThreads(std::max(1, cv::getNumberOfCPUs() / 4));
}

}  // namespace lcmslam
