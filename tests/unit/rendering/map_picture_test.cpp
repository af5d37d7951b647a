#include <lcmslam/rendering/map_picture.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/rendering/front_heading.hpp>
#include <lcmslam/rendering/picture_points.hpp>
#include <lcmslam/rendering/point_spacing.hpp>
#include "tests/unit/map_store/sample_map.hpp"

namespace lcmslam {
namespace {

const cv::Vec3b red(20, 20, 220), green(20, 220, 20), blue(220, 20, 20), grey(128, 128, 128);

/// A flat patch of points 4 cm apart around `centre`, spanned by two directions.
void add_patch(ColouredCloud& cloud, const Eigen::Vector3d& centre, const Eigen::Vector3d& half_u,
               const Eigen::Vector3d& half_v, const Eigen::Vector3d& normal, const cv::Vec3b& colour) {
  const int steps_u = static_cast<int>(half_u.norm() / 0.04),
            steps_v = static_cast<int>(half_v.norm() / 0.04);
  for (int i = -steps_u; i <= steps_u; ++i)
    for (int j = -steps_v; j <= steps_v; ++j) {
      const Eigen::Vector3d point = centre + half_u * i / steps_u + half_v * j / steps_v;
      cloud.points.push_back(point.cast<float>());
      cloud.normals.push_back(normal.cast<float>());
      cloud.colours.push_back(colour);
    }
}

/// A closed room, 6 x 4 x 2.5 m, seen from inside: red floor, green ceiling, grey walls but the blue
/// one at the far end (x = 6).
ColouredCloud room() {
  using Eigen::Vector3d;
  ColouredCloud cloud;
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  add_patch(cloud, {3, 0, 0}, 3 * x, 2 * y, z, red);
  add_patch(cloud, {3, 0, 2.5}, 3 * x, 2 * y, -z, green);
  add_patch(cloud, {3, 2, 1.25}, 3 * x, 1.25 * z, -y, grey);
  add_patch(cloud, {3, -2, 1.25}, 3 * x, 1.25 * z, y, grey);
  add_patch(cloud, {0, 0, 1.25}, 2 * y, 1.25 * z, x, grey);
  add_patch(cloud, {6, 0, 1.25}, 2 * y, 1.25 * z, -x, blue);
  return cloud;
}

PictureRequest request_of(const ColouredCloud& cloud, MapView view) {
  PictureRequest request;
  request.view = view;
  request.cloud = &cloud;
  request.resolution = 0.04;
  request.width = 400;
  request.height = 300;
  return request;
}

/// Share of the picture's pixels within 40 of a colour.
double share_of(const cv::Mat& picture, const cv::Vec3b& colour) {
  double count = 0;
  for (int row = 0; row < picture.rows; ++row)
    for (int column = 0; column < picture.cols; ++column)
      if (cv::norm(picture.at<cv::Vec3b>(row, column), colour, cv::NORM_INF) < 40) ++count;
  return count / static_cast<double>(picture.total());
}

bool near_colour(const cv::Vec3b& a, const cv::Vec3b& b) {
  return cv::norm(a, b, cv::NORM_INF) < 40;
}

TEST(MapPicture, PointsStandWhereTheProjectionSays) {
  ColouredCloud cloud;
  for (const double y : {-0.5, 0.5})
    add_patch(cloud, {2, y, 0}, {0, 0.15, 0}, {0, 0, 0.15}, -Eigen::Vector3d::UnitX(), y < 0 ? red : green);
  PictureRequest request = request_of(cloud, MapView::front);
  request.T_world_viewer = optical_axes();  // at the origin, looking along x
  request.field_of_view = 1.0;
  const cv::Mat picture = draw_map(request);
  const double focal = 200 / std::tan(0.5);
  const auto pixel = [&](double y, double z) {
    return picture.at<cv::Vec3b>(cvRound(150 - focal * z / 2), cvRound(200 - focal * y / 2));
  };
  EXPECT_TRUE(near_colour(pixel(-0.5, 0), red));
  EXPECT_TRUE(near_colour(pixel(0.5, 0), green));
  EXPECT_TRUE(near_colour(pixel(0.5, 0.14), green));
  EXPECT_FALSE(near_colour(pixel(0.5, 0.25), green)) << "outside the patch";
  EXPECT_TRUE(near_colour(pixel(0, 0), cv::Vec3b(250, 250, 250))) << "background between the patches";
}

TEST(MapPicture, NearSurfacesHideFarOnes) {
  ColouredCloud cloud;
  const Eigen::Vector3d towards = -Eigen::Vector3d::UnitX();
  add_patch(cloud, {2, 0, 0}, {0, 0.2, 0}, {0, 0, 0.2}, towards, red);
  add_patch(cloud, {3, 0, 0}, {0, 0.9, 0}, {0, 0, 0.9}, towards, blue);
  PictureRequest request = request_of(cloud, MapView::front);
  request.T_world_viewer = optical_axes();
  const cv::Mat picture = draw_map(request);
  EXPECT_TRUE(near_colour(picture.at<cv::Vec3b>(150, 200), red));
  EXPECT_TRUE(near_colour(picture.at<cv::Vec3b>(150, 270), blue));
}

TEST(MapPicture, PaintColoursSurfacesAndIsNothingItself) {
  ColouredCloud wall, paint;
  add_patch(wall, {2, 0, 0}, {0, 1, 0}, {0, 0, 1}, -Eigen::Vector3d::UnitX(), grey);
  for (float z = -1; z <= 1; z += 0.01F)
    for (float y = -1; y <= 1; y += 0.01F) {
      paint.points.emplace_back(2.01F, 0.5F * y, z);  // a little behind the wall, which is no obstacle
      paint.points.emplace_back(1.5F, 3 + y, z);      // where no surface is
    }
  paint.colours.resize(paint.size(), red);
  PictureRequest request = request_of(wall, MapView::front);
  request.resolution = 0.01;
  request.T_world_viewer = Eigen::Translation3d(-1, 0, 0) * optical_axes();
  EXPECT_EQ(share_of(draw_map(request), red), 0);
  const double all = share_of(draw_map(request), grey);
  request.paint = &paint;
  const cv::Mat picture = draw_map(request);
  EXPECT_NEAR(share_of(picture, red), all / 2, all / 10);
  EXPECT_NEAR(share_of(picture, grey), all / 2, all / 10);
}

TEST(MapPicture, SparseSurfacesAreClosedAndDenseOnesSharp) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 200; ++i)
    for (int j = 0; j < 200; ++j)
      points.emplace_back(0.005F * static_cast<float>(i), 0.005F * static_cast<float>(j), 0.001F);
  const std::size_t dense = points.size();
  for (int i = 0; i < 50; ++i)
    for (int j = 0; j < 50; ++j)
      points.emplace_back(5 + 0.02F * static_cast<float>(i), 0.02F * static_cast<float>(j), 0.001F);
  const std::size_t sparse = points.size();
  points.emplace_back(0, 0, 7);
  const std::vector<float> spacing = point_spacing(points, 0.005, 0.03);
  EXPECT_NEAR(spacing[100 * 200 + 100], 0.005F, 1e-4F);
  EXPECT_NEAR(spacing[dense + 25 * 50 + 25], 0.02F, 0.003F);
  EXPECT_EQ(spacing[sparse], 0.005F) << "a lonely point";
}

TEST(MapPicture, TheTopViewShowsTheFloorAndNotTheCeiling) {
  ColouredCloud cloud = room();
  const cv::Mat picture = draw_map(request_of(cloud, MapView::top));
  EXPECT_GT(share_of(picture, red), 0.4);
  EXPECT_LT(share_of(picture, green), 0.001);

  cloud.normals.clear();
  const cv::Mat without = draw_map(request_of(cloud, MapView::top));
  EXPECT_GT(share_of(without, red), 0.4) << "the ceiling is found by its height";
  EXPECT_LT(share_of(without, green), 0.001);
}

TEST(MapPicture, NormalsOfZeroAreUnknown) {
  ColouredCloud zero = room(), none = zero;
  for (Eigen::Vector3f& normal : zero.normals) normal.setZero();
  none.normals.clear();
  for (const MapView view : {MapView::top, MapView::front})
    EXPECT_EQ(cv::norm(draw_map(request_of(zero, view)), draw_map(request_of(none, view)), cv::NORM_INF), 0);
}

TEST(MapPicture, TheFrontViewLooksIntoTheRoom) {
  ColouredCloud cloud = room();
  for (const bool normals : {true, false}) {
    if (!normals) cloud.normals.clear();
    const cv::Mat picture = draw_map(request_of(cloud, MapView::front));
    EXPECT_GT(share_of(picture, red), 0.05) << "floor, normals: " << normals;
    EXPECT_GT(share_of(picture, blue), 0.03) << "far wall, normals: " << normals;
    EXPECT_LT(share_of(picture, green), 0.01) << "ceiling, normals: " << normals;
  }
}

TEST(MapPicture, AGivenCutAppliesToAllPoints) {
  ColouredCloud cloud;
  add_patch(cloud, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, Eigen::Vector3d::UnitZ(), red);
  add_patch(cloud, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, Eigen::Vector3d::UnitZ(), green);
  PictureRequest request = request_of(cloud, MapView::top);
  EXPECT_GT(share_of(draw_map(request), green), 0.2);
  request.cut_height = 0.5;
  const cv::Mat cut = draw_map(request);
  EXPECT_LT(share_of(cut, green), 0.001);
  EXPECT_GT(share_of(cut, red), 0.2);
}

TEST(MapPicture, PathsAndLandmarksAreDrawn) {
  PictureRequest request;
  request.width = 400;
  request.height = 300;
  request.paths.push_back({"robot", blue, {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}}});
  Landmark dot = landmark(1, 1, 1, 0);
  dot.colour = {220, 20, 20};
  const std::vector<Landmark> landmarks(1, dot);
  request.landmarks = &landmarks;
  for (const MapView view : {MapView::top, MapView::front}) {
    request.view = view;
    const cv::Mat picture = draw_map(request);
    EXPECT_GT(share_of(picture, blue), 0.002);
    EXPECT_GT(share_of(picture, red), 1e-5);
  }
}

TEST(MapPicture, EmptyAndUselessMapsGiveAPicture) {
  PictureRequest request;
  ColouredCloud cloud;
  const std::vector<Landmark> none;
  request.landmarks = &none;
  for (const MapView view : {MapView::top, MapView::front})
    for (const std::size_t points : {0, 1, 2}) {
      cloud.points.assign(points, Eigen::Vector3f(1, points == 2 ? NAN : 1, 1));
      cloud.colours.assign(points, red);
      request.view = view;
      request.cloud = &cloud;
      const cv::Mat picture = draw_map(request);
      EXPECT_EQ(picture.size(), cv::Size(1600, 1200));
      double low, high;
      cv::minMaxLoc(picture.reshape(1), &low, &high);
      EXPECT_LT(low, high) << "something is written";
    }
}

TEST(MapPicture, WrongSettingsAreRefused) {
  PictureRequest request;
  request.width = 10;
  EXPECT_THROW(draw_map(request), std::invalid_argument);
  request = {};
  request.resolution = 0;
  EXPECT_THROW(draw_map(request), std::invalid_argument);
  request = {};
  request.field_of_view = 3.2;
  EXPECT_THROW(draw_map(request), std::invalid_argument);
}

TEST(MapPicture, IsTheSameEveryTimeAndSurvivesThePng) {
  const TemporaryFolder folder;
  const ColouredCloud cloud = room();
  const cv::Mat picture = draw_map(request_of(cloud, MapView::front));
  save_picture(folder / "map.png", picture);
  const cv::Mat again = draw_map(request_of(cloud, MapView::front));
  const cv::Mat read = cv::imread((folder / "map.png").string());
  EXPECT_EQ(cv::norm(picture, again, cv::NORM_INF), 0);
  ASSERT_EQ(read.size(), picture.size());
  EXPECT_EQ(cv::norm(picture, read, cv::NORM_INF), 0);
  EXPECT_THROW(save_picture(folder / "none/map.png", picture), std::runtime_error);
  EXPECT_THROW(save_picture(folder / "empty.png", cv::Mat()), std::runtime_error);
}

TEST(FrontHeading, LongSideStartAndOneSidedMaps) {
  ColouredCloud cloud = room();
  PictureRequest request = request_of(cloud, MapView::front);
  const auto heading = [&] { return front_heading(request, PicturePoints(request).extent(nullptr)); };
  EXPECT_GT(heading().x(), 0.99) << "from x = 0, where a robot without path started";
  request.paths.push_back({"", red, {{5.5, 0, 0}, {1, 0, 0}}});
  EXPECT_LT(heading().x(), -0.99) << "from the other end";

  ColouredCloud wall;  // a long wall at y = 3, seen from the origin
  add_patch(wall, {0, 3, 1}, {3, 0, 0}, {0, 0, 1}, -Eigen::Vector3d::UnitY(), grey);
  request = request_of(wall, MapView::front);
  EXPECT_GT(heading().y(), 0.99);
  request.paths.push_back({"", red, {{-2, 0, 0}, {2, 0, 0}}});
  for (Eigen::Vector3f& normal : wall.normals) normal.setZero();  // as files have it
  EXPECT_GT(heading().y(), 0.99) << "from where it was seen, normals of 0 0 0";
  wall.normals.clear();
  EXPECT_GT(heading().y(), 0.99) << "from where it was seen";
}

}  // namespace
}  // namespace lcmslam
