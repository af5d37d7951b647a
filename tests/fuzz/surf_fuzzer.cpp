// Any image (size, stride, channels, content), mask, setting and provided keypoint: either refused with
// std::invalid_argument, or keypoints within the image and descriptors of unit norm or 0.

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include <lcmslam/parallel/instruction_set.hpp>
#include <lcmslam/surf/surf.hpp>

namespace lcmslam {
namespace {

class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  int next() { return at_ < size_ ? data_[at_++] : 0; }
  float number() {
    float value = 0;
    std::uint8_t bytes[sizeof value];
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(next());
    std::memcpy(&value, bytes, sizeof value);
    return value;
  }
  /// The input's bytes over and over, or a few large patches.
  std::uint8_t texture(int x, int y, int kind) const {
    if (size_ == 0) return 0;
    const int block = 1 << (kind % 6);
    const auto index = static_cast<std::size_t>(y / block * 37 + x / block);
    return kind < 250 ? data_[index % size_] : data_[0];
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_, at_ = 0;
};

/// A view into a larger image, so that a read beyond its rows and columns is noticed by its content.
cv::Mat image_of(Input& input, int type, cv::Size size) {
  const int margin_x = input.next() % 5, margin_y = input.next() % 3, kind = input.next();
  cv::Mat whole(size.height + 2 * margin_y, size.width + 2 * margin_x, type, cv::Scalar::all(255));
  cv::Mat view = whole(cv::Rect(margin_x, margin_y, size.width, size.height));
  for (int y = 0; y < view.rows; ++y)
    for (int x = 0; x < static_cast<int>(view.elemSize()) * view.cols; ++x)
      view.ptr<std::uint8_t>(y)[x] = input.texture(x, y, kind);
  return view;
}

struct Found {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
};

void expect(bool condition) {
  if (!condition) std::abort();
}

void check(const Found& found, const Surf& surf, cv::Size size, bool provided) {
  expect(found.descriptors.rows == static_cast<int>(found.keypoints.size()));
  for (int k = 0; k < found.descriptors.rows; ++k) {
    const cv::KeyPoint& p = found.keypoints[static_cast<std::size_t>(k)];
    expect(p.angle >= 0);
    if (!provided)
      expect(p.pt.x >= 0 && p.pt.y >= 0 && p.pt.x <= static_cast<float>(size.width - 1) &&
             p.pt.y <= static_cast<float>(size.height - 1) && p.size > 0 && p.angle <= 360);
    const double norm = cv::norm(found.descriptors.row(k));
    expect(norm == 0 || std::abs(norm - 1) < 1e-3);
  }
  if (!found.keypoints.empty()) expect(found.descriptors.cols == surf.descriptorSize());
}

}  // namespace
}  // namespace lcmslam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcmslam;
  cv::setNumThreads(1);
  Input input(data, size);
  SurfSettings settings;
  settings.octaves = 1 + input.next() % 6;
  settings.intervals = 3 + input.next() % 6;
  settings.hessian_threshold = input.next() * input.next() / 8.;
  settings.edge_ratio = 1 + input.next();
  settings.upright = input.next() % 2 == 1;
  settings.extended = input.next() % 2 == 1;
  settings.budget.max_features = input.next() * 2;
  const int types[] = {CV_8UC1, CV_8UC1, CV_8UC3, CV_8UC4, CV_8UC2, CV_16UC1, CV_32FC1};
  const int type = types[input.next() % 7];
  const cv::Size image_size(input.next() % 200, input.next() % 160);
  const bool masked = input.next() % 4 == 0, provided = input.next() % 3 == 0;
  std::vector<cv::KeyPoint> keypoints;
  for (int i = input.next() % 8; provided && i > 0; --i) {
    const float x = input.number(), y = input.number(), diameter = input.number(), angle = input.number();
    keypoints.emplace_back(x, y, diameter, angle);
  }
  const cv::Mat image = image_of(input, type, image_size);
  const cv::Mat mask = masked ? image_of(input, CV_8UC1, image_size) : cv::Mat();
  try {
    Surf surf(settings);
    Found found[2];
    for (int i = 0; i < 2; ++i) {
      limit_instruction_set(i == 0 ? InstructionSet::portable : InstructionSet::avx2);
      found[i].keypoints = keypoints;
      surf.detectAndCompute(image, mask, found[i].keypoints, found[i].descriptors, provided);
      check(found[i], surf, image_size, provided);
    }
    expect(found[0].keypoints.size() == found[1].keypoints.size());
    expect(found[0].descriptors.empty() || std::memcmp(found[0].descriptors.data, found[1].descriptors.data,
                                                       found[0].descriptors.total() * sizeof(float)) == 0);
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
