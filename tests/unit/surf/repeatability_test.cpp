// Ours beside dlib's SURF on recorded images: how many keypoints of one image are found again where the
// depth image and the camera's motion say they must be, and how many of these the descriptor
// matches. The same number of keypoints for both.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <sstream>

#include <lcmslam/features/matching.hpp>
#include <lcmslam/features/rigid_ransac.hpp>
#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/surf/surf.hpp>
#include "tests/support/recordings.hpp"
#include "tests/unit/surf/dlib_surf.hpp"

namespace lcmslam {
namespace {

#ifdef LCMSLAM_HAS_DLIB

struct View {
  double time;
  cv::Mat grey, depth;
};

View load(const std::filesystem::path& folder, const std::string& association) {
  std::istringstream fields(association);
  View view;
  std::string colour, depth_time, depth;
  fields >> view.time >> colour >> depth_time >> depth;
  view.grey = cv::imread((folder / colour).string(), cv::IMREAD_GRAYSCALE);
  view.depth = cv::imread((folder / depth).string(), cv::IMREAD_UNCHANGED);
  return view;
}

struct Keypoint {
  double x, y, scale;
  std::array<float, 64> descriptor;
};

using Detector = std::function<std::vector<Keypoint>(const cv::Mat&)>;
constexpr int keypoints_each = 400;

std::vector<Keypoint> ours(const cv::Mat& grey) {
  SurfSettings settings;
  settings.hessian_threshold = 5;  // the number of keypoints decides
  settings.budget.max_features = keypoints_each;
  settings.budget.cell_share = 1e6;  // the strongest wherever they are, as dlib takes them
  std::vector<cv::KeyPoint> found;
  cv::Mat descriptors;
  Surf(settings).detectAndCompute(grey, cv::noArray(), found, descriptors);
  std::vector<Keypoint> keypoints;
  for (std::size_t i = 0; i < found.size(); ++i) {
    keypoints.push_back({found[i].pt.x, found[i].pt.y, scale_of_filter(found[i].size), {}});
    std::copy_n(descriptors.ptr<float>(int(i)), 64, keypoints.back().descriptor.begin());
  }
  return keypoints;
}

std::vector<Keypoint> of_dlib(const cv::Mat& grey) {
  std::vector<Keypoint> keypoints;
  for (const auto& p : dlib::get_surf_points(dlib::cv_image<unsigned char>(grey), keypoints_each, 1.)) {
    keypoints.push_back({p.p.center.x(), p.p.center.y(), p.p.scale, {}});
    for (long k = 0; k < 64; ++k) keypoints.back().descriptor[std::size_t(k)] = float(p.des(k));
  }
  return keypoints;
}

struct Score {
  int pairs = 0, keypoints = 0, visible = 0, repeated = 0, matched = 0;
  double milliseconds = 0;
  double repeatability() const { return double(repeated) / visible; }
  double matching() const { return double(matched) / visible; }
};

// The recording's colour camera: Brown's distortion of normalised coordinates.
constexpr double fx = 517.3, fy = 516.5, cx = 318.6, cy = 255.3;

Eigen::Vector2d distort(const Eigen::Vector2d& n) {
  constexpr double k1 = 0.2624, k2 = -0.9531, p1 = -0.0054, p2 = 0.0026, k3 = 1.1633;
  const double r2 = n.squaredNorm(), radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {n.x() * radial + 2 * p1 * n.x() * n.y() + p2 * (r2 + 2 * n.x() * n.x()),
          n.y() * radial + p1 * (r2 + 2 * n.y() * n.y()) + 2 * p2 * n.x() * n.y()};
}

Eigen::Vector2d undistort(const Eigen::Vector2d& distorted) {
  Eigen::Vector2d n = distorted;
  for (int i = 0; i < 20; ++i) n += distorted - distort(n);
  return n;
}

// The point seen at a pixel, metres; nothing where the depth image has a hole.
std::optional<Eigen::Vector3d> point_at(const View& view, double x, double y) {
  const double z = view.depth.at<std::uint16_t>(int(std::lround(y)), int(std::lround(x))) / 5000.;
  if (z == 0) return std::nullopt;
  const Eigen::Vector2d ray = undistort({(x - cx) / fx, (y - cy) / fy});
  return Eigen::Vector3d(ray.x() * z, ray.y() * z, z);
}

// The camera's motion from the matches of both detectors together. (The recording's measured poses are
// off by several pixels at the speed of these turns.)
std::optional<Eigen::Isometry3d> motion(const View& a, const View& b,
                                        const std::array<std::vector<Keypoint>, 2>& in_a,
                                        const std::array<std::vector<Keypoint>, 2>& in_b) {
  std::vector<PointPair> pairs;
  for (std::size_t d = 0; d < 2; ++d) {
    std::vector<Descriptor> bytes_a, bytes_b;
    for (const Keypoint& p : in_a[d]) bytes_a.push_back(to_bytes(p.descriptor.data()));
    for (const Keypoint& p : in_b[d]) bytes_b.push_back(to_bytes(p.descriptor.data()));
    for (const Match& m : match(bytes_a, bytes_b)) {
      const Keypoint &p = in_a[d][std::size_t(m.a)], &q = in_b[d][std::size_t(m.b)];
      const auto point_a = point_at(a, p.x, p.y), point_b = point_at(b, q.x, q.y);
      if (!point_a || !point_b) continue;
      const auto covariance = [](const Eigen::Vector3d& point) -> Eigen::Matrix3d {
        const double across = 2 / fx * point.z(), along = 0.003 + 0.003 * point.z() * point.z();
        return Eigen::Vector3d(across * across, across * across, along * along).asDiagonal();
      };
      pairs.push_back({*point_b, *point_a, covariance(*point_b), covariance(*point_a)});
    }
  }
  Random random(1);
  const auto result = align_ransac(pairs, {}, random);
  if (!result.success) return std::nullopt;
  return result.T_a_b;
}

// Where a keypoint of a with depth is seen in b; false when it is not.
bool transfer(const View& a, const View& b, const Eigen::Isometry3d& T_b_a, const Keypoint& keypoint,
              cv::Point2d& place) {
  const auto in_a = point_at(a, keypoint.x, keypoint.y);
  if (!in_a) return false;
  const Eigen::Vector3d p = T_b_a * *in_a;
  if (p.z() < 0.1 || p.head<2>().norm() > p.z()) return false;
  const Eigen::Vector2d n = distort(p.head<2>() / p.z());
  place = {fx * n.x() + cx, fy * n.y() + cy};
  if (place.x < 15 || place.y < 15 || place.x > 624 || place.y > 464) return false;
  const double seen = b.depth.at<std::uint16_t>(int(place.y), int(place.x)) / 5000.;
  return seen > 0 && std::abs(seen - p.z()) < 0.05 * p.z();  // not hidden behind something
}

void add(Score& score, const std::vector<Keypoint>& from, const std::vector<Keypoint>& to, const View& a,
         const View& b, const Eigen::Isometry3d& T_b_a) {
  constexpr double tolerance = 3;  // pixels
  for (const Keypoint& p : from) {
    cv::Point2d place;
    if (!transfer(a, b, T_b_a, p, place)) continue;
    ++score.visible;
    const auto is_same = [&](const Keypoint& q) {
      return std::hypot(q.x - place.x, q.y - place.y) < tolerance &&
             std::abs(std::log(q.scale / p.scale)) < std::log(1.5);
    };
    const bool found = std::any_of(to.begin(), to.end(), is_same);
    score.repeated += found;
    if (!found) continue;
    const Keypoint* nearest = nullptr;
    double least = 1e9;
    for (const Keypoint& q : to) {
      double distance = 0;
      for (std::size_t k = 0; k < 64; ++k) distance += std::pow(p.descriptor[k] - q.descriptor[k], 2);
      if (distance < least) {
        least = distance;
        nearest = &q;
      }
    }
    score.matched += is_same(*nearest);
  }
}

TEST(SurfRepeatability, IsNoWorseThanDlibs) {
  const auto folder = recording_path("tum_fr1_rpy");
  LCMSLAM_SKIP_WITHOUT("tum_fr1_rpy");
  std::vector<std::string> associations;
  std::ifstream file(folder / "associations.txt");
  for (std::string line; std::getline(file, line);)
    if (!line.empty() && line[0] != '#') associations.push_back(line);
  ASSERT_GT(associations.size(), 600u);

  const std::pair<const char*, Detector> detectors[] = {{"ours", ours}, {"dlib", of_dlib}};
  std::map<int, std::array<Score, 2>> scores;  // by frames apart
  for (std::size_t first = 20; first + 30 < associations.size(); first += 60) {
    const View a = load(folder, associations[first]);
    std::array<std::vector<Keypoint>, 2> in_a;
    for (std::size_t d = 0; d < 2; ++d) in_a[d] = detectors[d].second(a.grey);
    for (int apart : {5, 15, 30}) {
      const View b = load(folder, associations[first + std::size_t(apart)]);
      ASSERT_FALSE(a.grey.empty() || a.depth.empty() || b.grey.empty() || b.depth.empty());
      std::array<std::vector<Keypoint>, 2> in_b;
      for (std::size_t d = 0; d < 2; ++d) {
        const auto start = cv::getTickCount();
        in_b[d] = detectors[d].second(b.grey);
        scores[apart][d].milliseconds += 1e3 * double(cv::getTickCount() - start) / cv::getTickFrequency();
      }
      const auto T_b_a = motion(a, b, in_a, in_b);
      if (!T_b_a) continue;  // too little in common for either
      for (std::size_t d = 0; d < 2; ++d) {
        Score& score = scores[apart][d];
        ++score.pairs;
        score.keypoints += int(in_b[d].size());
        add(score, in_a[d], in_b[d], a, b, *T_b_a);
      }
    }
  }
  ASSERT_EQ(scores.size(), 3u);
  double repeatability[2] = {}, matching[2] = {};
  for (const auto& [apart, both] : scores)
    for (std::size_t d = 0; d < 2; ++d) {
      const Score& score = both[d];
      ASSERT_GT(score.visible, 100);
      std::printf(
          "[          ] %2d frames apart, %s: repeated %.3f, matched %.3f of %d visible in %d pairs (%d "
          "keypoints, %.0f ms)\n",
          apart, detectors[d].first, score.repeatability(), score.matching(), score.visible, score.pairs,
          score.keypoints, score.milliseconds);
      repeatability[d] += score.repeatability() / 3;
      matching[d] += score.matching() / 3;
    }
  EXPECT_GE(repeatability[0], repeatability[1] - 0.05);
  EXPECT_GE(matching[0], matching[1] - 0.05);
}

#else

TEST(SurfRepeatability, IsNoWorseThanDlibs) {
  GTEST_SKIP() << "dlib's headers (libdlib-dev) are not installed";
}

#endif

}  // namespace
}  // namespace lcmslam
