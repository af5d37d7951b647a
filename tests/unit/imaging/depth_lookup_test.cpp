// Depth looked up around some pixels alone, against the whole image's registration; and the whole image's
// registration against one that takes every step in the plainest way.

#include <gtest/gtest.h>

#include <cstring>

#include <lcmslam/imaging/depth_registration.hpp>
#include <lcmslam/parallel/instruction_set.hpp>
#include "tests/support/analytic_scene.hpp"
#include "tests/support/same_bits.hpp"

namespace lcmslam {
namespace {

using namespace testing_scene;

struct LookupCase {
  const char* name;
  bool registered, coarse;
  double baseline;    // m
  double distortion;  // k1 of the colour camera
  bool moved, holes, amplitude;
};

std::ostream& operator<<(std::ostream& out, const LookupCase& c) {
  return out << c.name;
}

// A room with boxes before its wall, one of them near enough to hide much; noise, holes.
struct Shot {
  RgbdCalibration calibration;
  RgbdFrame frame;
  Eigen::Isometry3d T_colour_depth_time = Eigen::Isometry3d::Identity();

  Shot(const LookupCase& c, std::uint64_t seed) {
    Random random(seed);
    calibration.colour = {320, 240, 260, 262, 161.5, 118.5, {}};
    if (c.distortion != 0) calibration.colour.distortion = {c.distortion, -0.3 * c.distortion, 0.001, -0.002};
    calibration.depth = {320, 240, 290, 290, 159.0, 121.0, {0.05, -0.1, 0.0, 0.001}};
    if (c.coarse) calibration.depth = {88, 72, 100, 101, 43.5, 36.5, {}};
    calibration.depth_registered = c.registered;
    calibration.T_colour_depth.translation() << c.baseline, 0.01, -0.004;
    calibration.T_colour_depth.linear() =
        Eigen::AngleAxisd(0.03, Eigen::Vector3d(0.2, 1, 0.3).normalized()).toRotationMatrix();
    calibration.depth_noise = {0.003, 0.001, 0, c.amplitude ? 0.001 : 0};
    if (c.registered) {
      calibration.depth = calibration.colour;
      calibration.T_colour_depth.setIdentity();
    }
    if (c.moved) {
      T_colour_depth_time.translation() << 0.02, -0.01, 0.015;
      T_colour_depth_time.rotate(Eigen::AngleAxisd(0.05, Eigen::Vector3d(1, 2, 3).normalized()));
    }
    Scene scene;
    scene.planes.push_back({Eigen::Vector3d(0.1, 0.05, 1).normalized(), 2.5});
    scene.planes.push_back({Eigen::Vector3d(0, 0.97, 0.24), 0.9});
    for (int i = 0; i < 6; ++i) {
      const Eigen::Vector3d at(random.uniform(-1, 1), random.uniform(-0.7, 0.6), random.uniform(0.4, 2));
      scene.boxes.emplace_back(at, at + Eigen::Vector3d(0.2, 0.25, 0.2));
    }
    frame.depth =
        render(scene, calibration.depth, calibration.T_colour_depth, &calibration.depth_noise, &random);
    if (c.amplitude) {
      frame.amplitude.create(frame.depth.size(), CV_8UC1);
      for (auto& value : cv::Mat_<std::uint8_t>(frame.amplitude))
        value = static_cast<std::uint8_t>(random.uniform(0, 255));
    }
    for (int i = 0; c.holes && i < 60; ++i)
      frame.depth(cv::Rect(static_cast<int>(random.uniform(0, frame.depth.cols - 9)),
                           static_cast<int>(random.uniform(0, frame.depth.rows - 9)), 8, 8)) = 0;
  }

  // Some lie outside of the image, some at its very rim.
  std::vector<cv::Point2f> queries(Random& random, int count) const {
    std::vector<cv::Point2f> pixels = {{-0.5f, -0.5f}, {0, 0},    {319.4f, 239.4f},
                                       {-3, 5},        {1e9f, 2}, {NAN, 7}};
    for (int i = 0; i < count; ++i)
      pixels.emplace_back(static_cast<float>(random.uniform(-1, 321)),
                          static_cast<float>(random.uniform(-1, 241)));
    return pixels;
  }
};

class DepthLookup : public testing::TestWithParam<LookupCase> {};

TEST_P(DepthLookup, IsThatOfTheWholeImageBitForBit) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Shot shot(GetParam(), seed);
    const DepthRegistration registration(shot.calibration);
    const RegisteredDepth whole = registration(shot.frame, shot.T_colour_depth_time);
    Random random(seed + 100);
    for (const int count : {1, 20, 600}) {
      const auto pixels = shot.queries(random, count);
      const auto expected = depth_at_pixels(whole, shot.calibration, pixels);
      const auto found = registration.depth_at_pixels(shot.frame, pixels, shot.T_colour_depth_time);
      ASSERT_EQ(found.size(), expected.size());
      int known = 0;
      for (std::size_t i = 0; i < pixels.size(); ++i) {
        const void *one = &found[i], *other = &expected[i];  // NaN equals NaN
        ASSERT_EQ(std::memcmp(one, other, sizeof found[i]), 0)
            << pixels[i] << " seed " << seed << ": " << found[i].point.transpose() << " instead of "
            << expected[i].point.transpose();
        known += std::isfinite(found[i].sigma) ? 1 : 0;
      }
      EXPECT_GE(known, count / 8) << "of " << count << ", seed " << seed;
    }
  }
}

TEST_P(DepthLookup, DoesNotDependOnTheInstructionSet) {
  const Shot shot(GetParam(), 5);
  const DepthRegistration registration(shot.calibration);
  Random random(6);
  const auto pixels = shot.queries(random, 200);
  const auto look_up = [&] {
    return registration.depth_at_pixels(shot.frame, pixels, shot.T_colour_depth_time);
  };
  const auto best = look_up();
  const RegisteredDepth best_whole = registration(shot.frame, shot.T_colour_depth_time);
  const InstructionSet former = limit_instruction_set(InstructionSet::portable);
  const auto plain = look_up();
  const RegisteredDepth plain_whole = registration(shot.frame, shot.T_colour_depth_time);
  limit_instruction_set(former);
  EXPECT_EQ(std::memcmp(best.data(), plain.data(), best.size() * sizeof best[0]), 0);
  EXPECT_TRUE(same_bits(best_whole.points, plain_whole.points));
  EXPECT_TRUE(same_bits(best_whole.sigma, plain_whole.sigma));
  EXPECT_TRUE(same_bits(best_whole.pixels, plain_whole.pixels));
}

// Pixels by CameraModel in double precision; each point covers its cells one by one.
TEST_P(DepthLookup, WholeImagesAreRegisteredAsStepByStep) {
  if (GetParam().registered && !GetParam().moved) return;  // depth pixels are colour's own
  const Shot shot(GetParam(), 7);
  const CameraModel& colour = shot.calibration.colour;
  const RegisteredDepth r = DepthRegistration(shot.calibration)(shot.frame, shot.T_colour_depth_time);
  const float cell = std::max(1.0f, 0.5f * r.footprint);
  const auto at = [&](double position) { return static_cast<int>(std::floor((position + 0.5) / cell)); };
  cv::Mat_<float> nearest(300, 400, 1e9f);
  const Eigen::Isometry3d T = shot.T_colour_depth_time * shot.calibration.T_colour_depth;
  const auto place = [&](int u, int v) -> std::optional<Eigen::Vector3d> {  // pixel and depth
    const double z = 0.001 * shot.frame.depth.at<std::uint16_t>(v, u);
    if (z < shot.calibration.depth_min) return std::nullopt;
    const Eigen::Vector3d point = T * Eigen::Vector3d(z * shot.calibration.depth.ray({u, v}));
    const auto pixel = colour.project(point);
    if (!pixel || !colour.contains(*pixel)) return std::nullopt;
    return Eigen::Vector3d(pixel->x(), pixel->y(), point.z());
  };
  for (int v = 0; v < r.points.rows; ++v)
    for (int u = 0; u < r.points.cols; ++u)
      if (const auto p = place(u, v))
        for (int y = std::max(0, at(p->y() - 0.6 * r.footprint)); y <= at(p->y() + 0.6 * r.footprint); ++y)
          for (int x = std::max(0, at(p->x() - 0.6 * r.footprint)); x <= at(p->x() + 0.6 * r.footprint); ++x)
            nearest(y, x) = std::min(nearest(y, x), static_cast<float>(p->z()));
  int seen = 0, hidden = 0, differ = 0;
  for (int v = 0; v < r.points.rows; ++v)
    for (int u = 0; u < r.points.cols; ++u) {
      const auto& pixel = r.pixels.at<cv::Vec2f>(v, u);
      const auto p = place(u, v);
      if (!p) {
        EXPECT_TRUE(std::isnan(pixel[0])) << u << " " << v;
        continue;
      }
      const auto z = [&](int du, int dv) {
        const bool inside = u + du >= 0 && v + dv >= 0 && u + du < r.points.cols && v + dv < r.points.rows;
        return inside ? r.points.at<cv::Vec3f>(v + dv, u + du)[2] : NAN;
      };
      const auto step = [&](int du, int dv) {
        const float a = std::abs(z(0, 0) - z(-du, -dv)), b = std::abs(z(du, dv) - z(0, 0));
        return std::isnan(a) ? (std::isnan(b) ? 0 : b) : std::isnan(b) ? a : std::min(a, b);
      };
      const float gap = z(0, 0) - nearest(at(p->y()), at(p->x())) - 6 * r.sigma.at<float>(v, u);
      const bool is_hidden = gap > 2 * (step(1, 0) + step(0, 1));
      (is_hidden ? hidden : seen) += 1;
      differ += is_hidden != std::isnan(pixel[0]) ? 1 : 0;
      if (!std::isnan(pixel[0])) {
        EXPECT_NEAR(pixel[0], p->x(), 1e-3);
        EXPECT_NEAR(pixel[1], p->y(), 1e-3);
      }
    }
  EXPECT_GT(seen, r.points.total() / 4);
  EXPECT_GT(hidden, GetParam().moved && GetParam().registered ? 20 : 50);
  EXPECT_LE(differ, hidden / 50) << "of " << hidden << " hidden ones";  // single precision, at cells' borders
}

INSTANTIATE_TEST_SUITE_P(
    Heads, DepthLookup,
    testing::Values(LookupCase{"Fine", false, false, -0.025, 0, false, true, false},
                    LookupCase{"WideBaseline", false, false, 0.2, -0.12, true, true, false},
                    LookupCase{"StrongLens", false, false, 0.05, 0.25, false, false, false},
                    LookupCase{"TimeOfFlight", false, true, 0.08, -0.12, true, true, true},
                    LookupCase{"Registered", true, false, 0, 0.1, false, true, false},
                    LookupCase{"RegisteredMoved", true, false, 0, 0.1, true, true, false}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace lcmslam
