#include <gtest/gtest.h>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/surface/colour_lookup.hpp>
#include "tests/support/analytic_scene.hpp"

namespace lcmslam {
namespace {

TEST(Lens, SeesNothingWhereItsPolynomialFoldsBack) {
  const CameraModel camera{160, 120, 200, 200, 79.5, 59.5, {-0.512, 0, 0, 0, 0}};
  const Lens lens(camera);
  EXPECT_NE(lens.pixel(0.4f, 0.3f, 1), lens.nothing);
  EXPECT_EQ(lens.pixel(1.2f * 0.8f, 1.2f * 0.6f, 1), lens.nothing);  // the polynomial leads it into the image
}

TEST(Lens, FindsThePixelThatTheCameraModelFinds) {
  CameraModel wide = testing_scene::tof_head().colour;
  wide.distortion = {-0.3, 0.1, 0.001, -0.002, -0.01, 0.02, 0.01, 0.001};
  Random random(3);
  for (const CameraModel& camera : {testing_scene::registered_head().colour, wide}) {
    const Lens lens(camera);
    int seen = 0;
    for (int i = 0; i < 3000; ++i) {
      const Eigen::Vector3d point(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-1, 4));
      const auto pixel = camera.project(point);
      const int expected =
          pixel && camera.contains(*pixel)
              ? static_cast<int>(pixel->y() + 0.5) * camera.width + static_cast<int>(pixel->x() + 0.5)
              : lens.nothing;
      const int found = lens.pixel(static_cast<float>(point.x()), static_cast<float>(point.y()),
                                   static_cast<float>(point.z()));
      if (found == expected || found == lens.nothing || expected == lens.nothing) {
        EXPECT_EQ(found, expected) << point.transpose();
        seen += found != lens.nothing;
        continue;
      }
      // Rounding may take the next pixel.
      EXPECT_LE(std::abs(found % camera.width - expected % camera.width), 1);
      EXPECT_LE(std::abs(found / camera.width - expected / camera.width), 1);
      ++seen;
    }
    EXPECT_GT(seen, 100);
  }
}

TEST(ColourLookup, WhatSomethingHidesHasNoColour) {
  const CameraModel camera{60, 40, 50, 50, 29.5, 19.5, {}};
  // A near strip, and a far wall of which the colour camera sees what the strip leaves.
  cv::Mat points(40, 120, CV_32FC3), found(40, 120, CV_8UC3, cv::Scalar::all(0)),
      seen(40, 120, CV_8UC1, cv::Scalar(0));
  for (int v = 0; v < 40; ++v)
    for (int u = 0; u < 120; ++u) {
      const float z = u < 60 ? 2.0f : 1.0f;
      const float x = u < 60 ? static_cast<float>(u) - 29.5f : (static_cast<float>(u) - 60) / 3 - 10;
      points.at<cv::Vec3f>(v, u) = {x / 50 * z, (static_cast<float>(v) - 19.5f) / 50 * z, z};
    }
  cv::Mat colour(40, 60, CV_8UC3);
  for (int v = 0; v < 40; ++v)
    for (int u = 0; u < 60; ++u) colour.at<cv::Vec3b>(v, u) = cv::Vec3b(static_cast<std::uint8_t>(u), 7, 9);
  look_up_colours(points, colour, Lens(camera), 1, found, seen);
  for (int u = 0; u < 60; ++u) {
    const bool hidden = u >= 21 && u <= 37;
    if (u == 19 || u == 20 || u == 38 || u == 39) continue;  // the strip's rim
    EXPECT_EQ(seen.at<std::uint8_t>(20, u), hidden ? 0 : 255) << u;
    if (hidden) continue;
    EXPECT_EQ(found.at<cv::Vec3b>(20, u), cv::Vec3b(static_cast<std::uint8_t>(u), 7, 9));
  }
}

}  // namespace
}  // namespace lcmslam
