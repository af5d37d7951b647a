#include <lcmslam/messages/feature_messages.hpp>

#include <gmock/gmock.h>

#include <lcmslam/messages/decode.hpp>
#include "tests/unit/messages/error_of.hpp"
#include "tests/unit/messages/samples.hpp"
#include "tests/unit/messages/wire_sample.hpp"

namespace lcmslam {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

const float nan_f = std::nanf("");

TEST(FeatureMessages, FrameComesBackAsItWas) {
  Random random(1);
  FeatureFrame frame = testing::some_features(random, 20);
  frame.features[3].kind = MeasurementKind::bearing;
  frame.features[3].point.setConstant(nan_f);
  frame.features[3].depth_sigma = nan_f;
  const auto bytes = encode_message(to_message(frame));
  const FeatureFrame back = from_message(decode_message<features_t>(bytes.data(), bytes.size()));
  EXPECT_EQ(back.utime, frame.utime);
  EXPECT_EQ(back.seq, frame.seq);
  EXPECT_EQ(back.sensor, frame.sensor);
  EXPECT_EQ(back.width, frame.width);
  EXPECT_EQ(back.height, frame.height);
  EXPECT_EQ(back.fx, frame.fx);
  EXPECT_EQ(back.fy, frame.fy);
  EXPECT_EQ(back.cx, frame.cx);
  EXPECT_EQ(back.cy, frame.cy);
  EXPECT_EQ(back.pixel_sigma, frame.pixel_sigma);
  EXPECT_EQ(back.sharpness, frame.sharpness);
  EXPECT_EQ(back.has_mount, frame.has_mount);
  EXPECT_TRUE(back.T_robot_camera.isApprox(frame.T_robot_camera, 1e-12));
  ASSERT_EQ(back.features.size(), frame.features.size());
  for (std::size_t i = 0; i < back.features.size(); ++i) {
    const Feature &a = back.features[i], &b = frame.features[i];
    EXPECT_EQ(a.x, b.x);
    EXPECT_EQ(a.y, b.y);
    EXPECT_EQ(a.size, b.size);
    EXPECT_EQ(a.angle, b.angle);
    EXPECT_EQ(a.response, b.response);
    EXPECT_EQ(a.laplacian, b.laplacian);
    EXPECT_EQ(a.octave, b.octave);
    EXPECT_EQ(a.kind, b.kind);
    EXPECT_EQ(a.landmark_id, b.landmark_id);
    EXPECT_EQ(a.colour, b.colour);
    EXPECT_EQ(a.descriptor, b.descriptor);
    if (b.kind != MeasurementKind::point) {
      EXPECT_TRUE(std::isnan(a.point.x()) && std::isnan(a.depth_sigma));
      continue;
    }
    EXPECT_EQ(a.point, b.point);
    EXPECT_EQ(a.depth_sigma, b.depth_sigma);
  }
}

TEST(FeatureMessages, NineHundredFeaturesStayBelowAHundredKilobytes) {
  Random random(2);
  const std::size_t bytes_of_500 = encode_message(to_message(testing::some_features(random, 500))).size();
  const std::size_t bytes_of_900 = encode_message(to_message(testing::some_features(random, 900))).size();
  EXPECT_LT(bytes_of_900, 100'000U);
  EXPECT_EQ((bytes_of_900 - bytes_of_500) / 400, 110U);
}

TEST(FeatureMessages, ImpossibleCamerasAreRefusedByName) {
  Random random(3);
  const features_t good = to_message(testing::some_features(random, 3));
  const auto error_with = [&](auto change) {
    features_t message = good;
    change(message);
    return error_of([&] { from_message(message); });
  };
  EXPECT_EQ(error_with([](auto&) {}), "");
  EXPECT_THAT(error_with([](auto& m) { m.width = 0; }), HasSubstr("width"));
  EXPECT_THAT(error_with([](auto& m) { m.height = -3; }), HasSubstr("height"));
  EXPECT_THAT(error_with([](auto& m) { m.fx = 0; }), HasSubstr("fx"));
  EXPECT_THAT(error_with([](auto& m) { m.fy = std::nan(""); }), HasSubstr("fy"));
  EXPECT_THAT(error_with([](auto& m) { m.cx = INFINITY; }), HasSubstr("cx"));
  EXPECT_THAT(error_with([](auto& m) { m.cy = 1e9; }), HasSubstr("cy"));
  EXPECT_THAT(error_with([](auto& m) { m.pixel_sigma = 0; }), HasSubstr("pixel_sigma"));
  EXPECT_THAT(error_with([](auto& m) { m.T_robot_camera.quat[1] = 3; }), HasSubstr("T_robot_camera"));
  EXPECT_THAT(error_with([](auto& m) { m.features[1].kind = 4; }), HasSubstr("feature kind"));
  EXPECT_THAT(error_with([](auto& m) { m.features[1].kind = -1; }), HasSubstr("feature kind"));
}

TEST(FeatureMessages, FeatureWithUnsoundDepthBecomesABearing) {
  Random random(4);
  const features_t good = to_message(testing::some_features(random, 1));
  const auto kind_with = [&](auto change) {
    features_t message = good;
    change(message.features[0]);
    return from_message(message).features.at(0).kind;
  };
  EXPECT_EQ(kind_with([](feature_t&) {}), MeasurementKind::point);
  EXPECT_EQ(kind_with([](feature_t& f) { f.point[0] = nan_f; }), MeasurementKind::bearing);
  EXPECT_EQ(kind_with([](feature_t& f) { f.point[1] = INFINITY; }), MeasurementKind::bearing);
  EXPECT_EQ(kind_with([](feature_t& f) { f.point[2] = -1; }), MeasurementKind::bearing);  // behind the camera
  EXPECT_EQ(kind_with([](feature_t& f) { f.point[2] = 1e6F; }), MeasurementKind::bearing);
  EXPECT_EQ(kind_with([](feature_t& f) { f.depth_sigma = 0; }), MeasurementKind::bearing);
  EXPECT_EQ(kind_with([](feature_t& f) { f.depth_sigma = nan_f; }), MeasurementKind::bearing);
}

TEST(FeatureMessages, FeatureWithoutAPlaceIsLeftOut) {
  Random random(5);
  features_t message = to_message(testing::some_features(random, 6));
  message.features[0].x = nan_f;
  message.features[1].y = INFINITY;
  message.features[2].size = nan_f;
  message.features[3].angle = nan_f;
  message.features[4].response = nan_f;
  EXPECT_EQ(from_message(message).features.size(), 1U);
}

TEST(FeatureMessages, MutatedFramesGiveUsableFeaturesOrAreRefused) {
  Random random(6);
  const auto good = encode_message(to_message(testing::some_features(random, 8)));
  int usable = 0;
  for (int i = 0; i < 5000; ++i) {
    auto bytes = good;
    testing::mutate(bytes, random);
    error_of([&] {
      const FeatureFrame frame = from_message(decode_message<features_t>(bytes.data(), bytes.size()));
      for (const Feature& f : frame.features) {
        ASSERT_TRUE(std::isfinite(f.x) && std::isfinite(f.y) && std::isfinite(f.size));
        // What every consumer computes first; it throws for a point that is none.
        ASSERT_TRUE(f.kind != MeasurementKind::point || point_covariance(f, frame).allFinite());
      }
      ++usable;
    });
  }
  EXPECT_GT(usable, 1000);
}

}  // namespace
}  // namespace lcmslam
