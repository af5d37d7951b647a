#include <lcmslam/evaluation/surface_error.hpp>

#include <gmock/gmock.h>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

TEST(TriangleDistance, FaceEdgesAndCorners) {
  const Triangle t = {Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(1, 0, 0), Eigen::Vector3f(0, 1, 0)};
  EXPECT_NEAR(distance({0.2f, 0.2f, 0.5f}, t), 0.5, 1e-6);
  EXPECT_NEAR(distance({0.2f, 0.2f, -0.5f}, t), 0.5, 1e-6);
  EXPECT_NEAR(distance({0.5f, -0.3f, 0.4f}, t), 0.5, 1e-6);   // beside an edge
  EXPECT_NEAR(distance({-3, -4, 0}, t), 5, 1e-6);             // off a corner
  EXPECT_NEAR(distance({1, 1, 0}, t), std::sqrt(0.5), 1e-6);  // beyond the long side
  const Triangle line = {Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(1, 0, 0), Eigen::Vector3f(2, 0, 0)};
  EXPECT_NEAR(distance({1, 0.25f, 0}, line), 0.25, 1e-6);
}

TEST(TriangleSurface, FindsTheNearestOfMany) {
  Random random(5);
  std::vector<Triangle> triangles;
  const auto corner = [&](double size) {
    return Eigen::Vector3f(static_cast<float>(random.uniform(0, size)),
                           static_cast<float>(random.uniform(0, size)),
                           static_cast<float>(random.uniform(0, size)));
  };
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3f at = corner(3);
    triangles.push_back({at, at + corner(0.5), at + corner(0.5)});
  }
  const TriangleSurface surface(triangles);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3f p = corner(3);
    float nearest = 0.3f;
    for (const Triangle& t : triangles) nearest = std::min(nearest, distance(p, t));
    EXPECT_FLOAT_EQ(surface.distance(p), nearest);
  }
  EXPECT_THROW(TriangleSurface({}, 0), std::invalid_argument);
}

TEST(SurfaceError, TellsMedianTailAndWhatIsFarOff) {
  const Triangle triangle = {Eigen::Vector3f(-9, -9, 0), Eigen::Vector3f(9, -9, 0), Eigen::Vector3f(0, 9, 0)};
  const TriangleSurface floor(std::vector<Triangle>(1, triangle));
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 100; ++i)
    points.emplace_back(0.01f * static_cast<float>(i), 0, 0.001f * static_cast<float>(i));
  points.emplace_back(0, 0, 5);
  points.emplace_back(0, 0, std::nanf(""));
  const SurfaceError error = surface_error(points, Eigen::Isometry3d(Eigen::Translation3d(0, 0, 0.1)), floor);
  EXPECT_EQ(error.points, 101U);
  EXPECT_NEAR(error.median, 0.15, 1e-3);
  EXPECT_NEAR(error.p95, 0.195, 1e-3);
  EXPECT_NEAR(error.beyond, 1.0 / 101, 1e-6);
}

TEST(SurfaceError, OfNoPointIsUnknown) {
  const TriangleSurface nothing(std::vector<Triangle>{});
  const SurfaceError error = surface_error({}, Eigen::Isometry3d::Identity(), nothing);
  EXPECT_EQ(error.points, 0U);
  for (const double figure : {error.median, error.p95, error.mean, error.beyond})
    EXPECT_TRUE(std::isnan(figure));
}

}  // namespace
}  // namespace lcmslam
