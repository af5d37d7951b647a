#include <lcmslam/imaging/sharpness.hpp>

#include <cstdint>
#include <cstdlib>

namespace lcmslam {

float sharpness(const cv::Mat& grey) {
  constexpr int every = 4;
  double sum = 0;
  int rows = 0;
  for (int y = 0; y < grey.rows; y += every, ++rows) {
    const auto* row = grey.ptr<std::uint8_t>(y);
    int line = 0;
    for (int x = 1; x < grey.cols; ++x) line += std::abs(row[x] - row[x - 1]);
    sum += line;
  }
  return rows > 0 && grey.cols > 1 ? static_cast<float>(sum / (rows * (grey.cols - 1))) : 0.f;
}

bool SharpnessWatch::observe(float sharpness) {
  constexpr float blurred_below = 0.6f, share = 1 / 30.f, share_of_blurred = 1 / 300.f;
  if (usual_ == 0) usual_ = sharpness;
  const bool blurred = sharpness < blurred_below * usual_;
  usual_ += (blurred ? share_of_blurred : share) * (sharpness - usual_);
  return blurred;
}

}  // namespace lcmslam
