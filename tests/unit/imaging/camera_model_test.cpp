// Camera model: against OpenCV's projection, and as its own inverse.

#include <lcmslam/imaging/camera_model.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

CameraModel camera(std::vector<double> distortion) {
  return {640, 480, 517.3, 516.5, 318.6, 255.3, std::move(distortion)};
}

// Lenses: ideal, 4, 5 (TUM freiburg1) and 8 coefficients.
const std::vector<std::vector<double>> lenses = {{},
                                                 {-0.28, 0.07, 0.0002, 0.00002},
                                                 {0.2624, -0.9531, -0.0054, 0.0026, 1.1633},
                                                 {0.45, -2.6, 0.0007, -0.0002, 1.5, 0.33, -2.4, 1.43}};

class CameraModelTest : public testing::TestWithParam<std::vector<double>> {};

TEST_P(CameraModelTest, ProjectsLikeOpenCv) {
  const CameraModel model = camera(GetParam());
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const double z = random.uniform(0.3, 8);
    const Eigen::Vector3d point(z * random.uniform(-0.6, 0.6), z * random.uniform(-0.45, 0.45), z);
    std::vector<cv::Point2d> expected;
    cv::projectPoints(std::vector<cv::Point3d>{{point.x(), point.y(), point.z()}}, cv::Vec3d(), cv::Vec3d(),
                      model.matrix(), model.distortion, expected);
    const auto pixel = model.project(point);
    ASSERT_TRUE(pixel.has_value());
    ASSERT_NEAR(pixel->x(), expected[0].x, 1e-9);
    ASSERT_NEAR(pixel->y(), expected[0].y, 1e-9);
  }
}

TEST_P(CameraModelTest, RayInvertsProjection) {
  const CameraModel model = camera(GetParam());
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d pixel(random.uniform(-0.5, 639.5), random.uniform(-0.5, 479.5));
    const Eigen::Vector3d ray = model.ray(pixel);
    ASSERT_EQ(ray.z(), 1);
    const auto back = model.project(random.uniform(0.5, 5) * ray);
    ASSERT_TRUE(back.has_value());
    ASSERT_LT((*back - pixel).norm(), 1e-7) << pixel.transpose();
  }
}

TEST_P(CameraModelTest, UndistortsLikeOpenCv) {
  const CameraModel model = camera(GetParam());
  Random random(3);
  for (int i = 0; i < 500; ++i) {
    const cv::Point2d pixel(random.uniform(0, 639), random.uniform(0, 479));
    std::vector<cv::Point2d> expected;
    cv::undistortPoints(std::vector<cv::Point2d>{pixel}, expected, model.matrix(), model.distortion,
                        cv::noArray(), model.matrix(),
                        cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 500, 1e-10));
    const Eigen::Vector2d ideal = model.undistort({pixel.x, pixel.y});
    ASSERT_NEAR(ideal.x(), expected[0].x, 1e-4);
    ASSERT_NEAR(ideal.y(), expected[0].y, 1e-4);
  }
}

TEST_P(CameraModelTest, RayTableHoldsTheRaysOfThePixels) {
  CameraModel model = camera(GetParam());
  const cv::Mat table = ray_table(model);
  ASSERT_EQ(table.type(), CV_32FC2);
  ASSERT_EQ(table.size(), cv::Size(640, 480));
  for (const auto& [u, v] : {std::pair{0, 0}, std::pair{639, 479}, std::pair{100, 400}}) {
    const Eigen::Vector3d ray = model.ray({u, v});
    EXPECT_NEAR(table.at<cv::Vec2f>(v, u)[0], ray.x(), 1e-6);
    EXPECT_NEAR(table.at<cv::Vec2f>(v, u)[1], ray.y(), 1e-6);
  }
}

// A row at a time, by the vector unit and without: the same bits, also where the lens shows nothing.
TEST_P(CameraModelTest, RowsHaveTheRaysOfTheirPixels) {
  const std::vector<double> folds = {-0.5, 0, 0, 0};  // at the sides it shows nothing
  ASSERT_FALSE(camera(folds).ray({0, 37}).allFinite());
  for (const std::vector<double>& lens : {GetParam(), folds}) {
    const CameraModel model = camera(lens);
    for (const auto limit : {InstructionSet::portable, InstructionSet::avx2}) {
      const InstructionSet before = limit_instruction_set(limit);
      std::vector<double> x(640), y(640);
      ray_row(model, 37, x.data(), y.data());
      limit_instruction_set(before);
      for (std::size_t u = 0; u < x.size(); ++u) {
        const Eigen::Vector3d ray = model.ray({static_cast<double>(u), 37});
        ASSERT_TRUE(std::isnan(ray.x()) ? std::isnan(x[u]) : x[u] == ray.x()) << u;
        ASSERT_TRUE(std::isnan(ray.y()) ? std::isnan(y[u]) : y[u] == ray.y()) << u;
      }
    }
  }
}

TEST(CameraModel, ARayTableIsMadeOnceForEachCamera) {
  const CameraModel one = camera({0.2624, -0.9531, -0.0054, 0.0026, 1.1633});
  CameraModel other = one;
  other.distortion[0] += 0.01;
  const cv::Mat table = ray_table(one), of_other = ray_table(other);
  EXPECT_EQ(ray_table(one).data, table.data);
  EXPECT_NE(of_other.data, table.data);
  EXPECT_NE(of_other.at<cv::Vec2f>(0, 0), table.at<cv::Vec2f>(0, 0));
  const cv::Mat before = table.clone();
  for (int width = 8; width < 16; ++width) {  // more cameras than are kept: whoever has a table keeps it
    other.width = width;
    EXPECT_EQ(ray_table(other).cols, width);
  }
  EXPECT_EQ(cv::norm(before, table, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(before, ray_table(one), cv::NORM_INF), 0);
}

INSTANTIATE_TEST_SUITE_P(Lenses, CameraModelTest, testing::ValuesIn(lenses));

TEST(CameraModel, NothingBehindTheCamera) {
  const CameraModel model = camera({});
  EXPECT_FALSE(model.project({0.1, 0.1, 0}));
  EXPECT_FALSE(model.project({0.1, 0.1, -1}));
  EXPECT_FALSE(model.project({0, 0, std::nan("")}));
}

// A barrel polynomial turns round far outside the view: at k1 = -0.28 beyond a tangent of 1.09. The
// mathematics alone would put such points back into the image.
TEST(CameraModel, PointsBeyondTheFoldAreNotProjected) {
  const CameraModel model = camera({-0.28, 0, 0, 0});
  const Eigen::Vector3d far_aside(1.7, 0, 1);
  const double folded = 517.3 * 1.7 * (1 - 0.28 * 1.7 * 1.7) + 318.6;
  ASSERT_GT(folded, 0);
  ASSERT_LT(folded, 639);  // it would have been inside
  EXPECT_FALSE(model.project(far_aside));
}

TEST(CameraModel, ScaledImageSeesTheSameRays) {
  const CameraModel model = camera({0.2624, -0.9531, -0.0054, 0.0026, 1.1633});
  const CameraModel half = model.scaled(0.5);
  EXPECT_EQ(half.width, 320);
  EXPECT_EQ(half.height, 240);
  // The corner shared by four large pixels is the centre of one small pixel.
  EXPECT_LT((half.ray({50, 60}) - model.ray({100.5, 120.5})).norm(), 1e-9);
  // The image's outer corner stays.
  EXPECT_LT((half.ray({-0.5, -0.5}) - model.ray({-0.5, -0.5})).norm(), 1e-9);
}

TEST(CameraModel, CheckNamesTheWrongValue) {
  const auto message = [](const CameraModel& model) -> std::string {
    try {
      model.check("colour");
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message(camera({0.2624, -0.9531, -0.0054, 0.0026, 1.1633})), "");
  CameraModel model = camera({});
  model.fx = -1;
  EXPECT_NE(message(model).find("colour.fx is -1"), std::string::npos);
  model = camera({});
  model.width = 0;
  EXPECT_NE(message(model).find("colour.width"), std::string::npos);
  EXPECT_NE(message(camera({1, 2, 3})).find("colour.distortion is 3"), std::string::npos);
  EXPECT_NE(message(camera({0, 0, 0, 0, std::nan("")})).find("finite"), std::string::npos);
  EXPECT_NE(message(camera({-3, 0, 0, 0})).find("folds"), std::string::npos);
}

}  // namespace
}  // namespace lcmslam
