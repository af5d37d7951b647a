#include <lcmslam/map_store/file/store_codecs.hpp>

#include <gmock/gmock.h>

#include "tests/unit/map_store_file/sample_store.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(CloudCodec, KeepsPositionsToATenthOfAMillimetre) {
  const ColouredCloud cloud = random_cloud(1, 3000, true);
  const ColouredCloud read = decode_cloud(encode_cloud(cloud));
  ASSERT_EQ(read.size(), cloud.size());
  EXPECT_EQ(read.colours, cloud.colours);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    EXPECT_LT((read.points[i] - cloud.points[i]).cwiseAbs().maxCoeff(), 0.51e-4F);
    EXPECT_LT(std::acos(std::min(1.F, read.normals[i].dot(cloud.normals[i]))), 0.01F);
  }
}

TEST(CloudCodec, GivesTheSamePointsEachTime) {
  const ColouredCloud once = decode_cloud(encode_cloud(random_cloud(2, 500, false)));
  const ColouredCloud twice = decode_cloud(encode_cloud(once));
  EXPECT_EQ(once.points, twice.points);
  EXPECT_TRUE(twice.normals.empty());
}

TEST(CloudCodec, WhatIsNowhereStaysUnknown) {
  ColouredCloud cloud = random_cloud(3, 3, true);
  cloud.points[1] = {NAN, 2e5F, -90'000};
  cloud.normals[2].setConstant(NAN);
  const ColouredCloud read = decode_cloud(encode_cloud(cloud));
  EXPECT_TRUE(std::isnan(read.points[1].x()) && std::isnan(read.points[1].y()));
  EXPECT_EQ(read.points[1].z(), -90'000);
  EXPECT_NEAR(read.points[2].x(), cloud.points[2].x(), 1e-4F) << "what follows is not shifted";
  EXPECT_TRUE(std::isnan(read.normals[2].x()));
}

TEST(CloudCodec, EmptyCloudsAreClouds) {
  EXPECT_EQ(decode_cloud(encode_cloud({})).size(), 0U);
}

// A wall that is seen row by row, as keyframes have it: whole millimetres, little texture.
TEST(CloudCodec, AViewOfAWallTakesLessThanHalf) {
  ColouredCloud wall;
  for (int v = 0; v < 100; ++v)
    for (int u = 0; u < 120; ++u) {
      wall.points.emplace_back(0.02F * static_cast<float>(u - 60), 0.02F * static_cast<float>(v - 50),
                               2.F + 0.001F * static_cast<float>((u * 7 + v * 3) % 5));
      const auto grey = static_cast<uchar>(120 + (u + v) % 7);
      wall.colours.emplace_back(grey, grey, grey);
      wall.normals.emplace_back(0, 0, -1);
    }
  EXPECT_LT(encode_cloud(wall).size(), wall.size() * 12 / 2) << "of the 12 bytes that a message takes";
}

TEST(FeatureCodec, KeepsEveryBit) {
  const FeatureFrame frame = some_frame_of_features(4, 50);
  const FeatureFrame read = decode_features(encode_features(frame));
  EXPECT_EQ(read.utime, frame.utime);
  EXPECT_EQ(read.sensor, frame.sensor);
  EXPECT_EQ(read.fy, frame.fy);
  EXPECT_TRUE(read.has_mount);
  EXPECT_TRUE(read.T_robot_camera.isApprox(frame.T_robot_camera, 1e-12));
  ASSERT_EQ(read.features.size(), 50U);
  EXPECT_EQ(read.features[7].descriptor, frame.features[7].descriptor);
  EXPECT_EQ(read.features[7].point, frame.features[7].point);
  EXPECT_EQ(read.features[8].kind, MeasurementKind::bearing);
  EXPECT_TRUE(std::isnan(read.features[8].point.x()));
  EXPECT_EQ(encode_features(read), encode_features(frame));
}

TEST(ImageCodec, KeepsTheBytesAsTheyTravelled) {
  const StoredImages images = some_images(6);
  const StoredImages read = decode_images(encode_images(images));
  EXPECT_EQ(read.frame.utime, 1000);
  EXPECT_EQ(read.frame.sensor, "head");
  EXPECT_EQ(read.frame.colour.coding, ImageCoding::jpeg);
  EXPECT_EQ(read.frame.colour.bytes, images.frame.colour.bytes);
  EXPECT_EQ(read.frame.depth.utime, 1016);
  EXPECT_EQ(read.frame.depth.width, 4);
  EXPECT_EQ(read.frame.depth.bytes, images.frame.depth.bytes);
  EXPECT_TRUE(read.T_colour_depth_time.isApprox(images.T_colour_depth_time, 1e-12));
}

TEST(ImageCodec, CodingsThatAreNoneAreRefused) {
  StoredImages images = some_images(6);
  images.frame.depth.coding = static_cast<ImageCoding>(99);
  EXPECT_THAT([&] { decode_images(encode_images(images)); },
              ThrowsMessage<BlobError>(HasSubstr("coding 99")));
}

TEST(LandmarkCodec, KeepsWhatMessagesSay) {
  const Landmark mark = some_landmark(5, 77);
  const Landmark read = decode_landmark(encode_landmark(mark));
  EXPECT_EQ(read.id, 77);
  EXPECT_EQ(read.mean, mark.mean);
  EXPECT_TRUE(read.covariance.isApprox(mark.covariance, 1e-6));
  EXPECT_EQ(read.descriptor, mark.descriptor);
  EXPECT_EQ(read.colour, mark.colour);
  EXPECT_EQ(read.observations, mark.observations);
  EXPECT_EQ(read.laplacian, mark.laplacian);
}

TEST(PoseCodec, KeepsPosesCovariancesEdgesAndPaths) {
  Random random(6);
  const Eigen::Isometry3d pose = random_pose(random);
  EXPECT_TRUE(decode_pose(encode_pose(pose)).isApprox(pose, 1e-14));
  Matrix6d covariance = Matrix6d::Random();
  covariance = (covariance * covariance.transpose()).eval();
  EXPECT_TRUE(decode_covariance(encode_covariance(covariance)).isApprox(covariance, 1e-6));
  const StoredEdge edge{1, 2, 2, pose, 0.01F, 0.02F, 3.F};
  const StoredEdge read = decode_edge(encode_edge(edge));
  EXPECT_EQ(read.kind, 2);
  EXPECT_EQ(read.sigma_rotation, 0.02F);
  EXPECT_TRUE(read.T_from_to.isApprox(pose, 1e-14));
  const auto path = decode_trajectory(encode_trajectory({{5, pose}, {6, Eigen::Isometry3d::Identity()}}));
  ASSERT_EQ(path.size(), 2U);
  EXPECT_EQ(path[1].utime, 6);
  EXPECT_TRUE(path[0].T_map_robot.isApprox(pose, 1e-14));
}

TEST(Blobs, EveryBitThatFlipsIsNoticed) {
  const Blob good = encode_landmark(some_landmark(7, 1));
  for (std::size_t byte = 0; byte < good.size(); ++byte) {
    Blob bad = good;
    bad[byte] = static_cast<std::uint8_t>(bad[byte] ^ (1U << (byte % 8)));
    EXPECT_THROW(decode_landmark(bad), BlobError) << byte;
  }
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_THROW(decode_landmark(Blob(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size))),
                 BlobError);
  EXPECT_THAT([&] { decode_cloud(good); }, ThrowsMessage<BlobError>(HasSubstr("kind 3, expected 5")));
}

// Their checksums are right: somebody wrote them so.
TEST(Blobs, ContentThatCannotBeIsRefused) {
  BlobWriter many;
  many.put(std::uint32_t{4'000'000'000});
  many.put(std::uint8_t{0});
  EXPECT_THAT([&] { decode_cloud(many.seal(BlobKind::cloud, true)); },
              ThrowsMessage<BlobError>(HasSubstr("4000000000 points")));
  BlobWriter claims;
  claims.put(std::uint32_t{4'000'000'000});  // as if that much had been deflated
  EXPECT_THAT([&] { decode_trajectory(claims.seal(BlobKind::trajectory, false)); },
              ThrowsMessage<BlobError>(HasSubstr("claims more")));
  BlobWriter nowhere;
  for (int i = 0; i < 7; ++i) nowhere.put(i == 3 ? 1.0 : double{NAN});
  EXPECT_THROW(decode_pose(nowhere.seal(BlobKind::pose, false)), BlobError);
  BlobWriter no_rotation;
  for (int i = 0; i < 7; ++i) no_rotation.put(0.0);
  EXPECT_THAT([&] { decode_pose(no_rotation.seal(BlobKind::pose, false)); },
              ThrowsMessage<BlobError>(HasSubstr("quaternion")));
}

}  // namespace
}  // namespace lcmslam
