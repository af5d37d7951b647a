#include <lcmslam/live_page/map_items.hpp>

#include <gtest/gtest.h>
#include <cstring>
#include <set>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

template <class Number>
Number number(const std::string& bytes, std::size_t at) {
  Number value;
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

DenseKeyframe keyframe(std::size_t n, float reach) {
  DenseKeyframe keyframe;
  keyframe.id = 7;
  keyframe.T_world_camera = planar_pose(1, 2, 0.5);
  Random random(1);
  for (std::size_t i = 0; i < n; ++i) {
    keyframe.cloud.points.emplace_back(random.uniform(-reach, reach), random.uniform(-reach, reach), reach);
    keyframe.cloud.colours.emplace_back(static_cast<uchar>(i), static_cast<uchar>(i >> 8), 3);
  }
  return keyframe;
}

TEST(PointsItems, EveryPointIsInOneLevelWithItsColour) {
  const DenseKeyframe shown = keyframe(3000, 2);
  std::set<std::size_t> seen;
  for (const PageItem& item : points_items(shown)) {
    const auto n = item.header["n"].get<std::size_t>();
    const auto unit = item.header["unit"].get<float>();
    ASSERT_EQ(item.bytes.size(), 9 * n);
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t colour = 6 * n + 3 * i;
      const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(item.bytes[at]); };
      const std::size_t which = byte(colour + 2) | static_cast<std::size_t>(byte(colour + 1)) << 8;
      ASSERT_LT(which, shown.cloud.size());
      EXPECT_EQ(byte(colour), 3) << "red comes first";
      EXPECT_TRUE(seen.insert(which).second);
      for (int axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(unit * number<std::int16_t>(item.bytes, 6 * i + 2 * static_cast<std::size_t>(axis)),
                    shown.cloud.points[which][axis], 0.51 * unit);
    }
  }
  EXPECT_EQ(seen.size(), shown.cloud.size());
}

TEST(PointsItems, TheFirstLevelIsAnEvenSample) {
  const DenseKeyframe shown = keyframe(20'000, 1);  // on a plane of 2 m x 2 m
  const auto items = points_items(shown);
  const auto n = [&](std::size_t level) { return items[level].header["n"].get<int>(); };
  EXPECT_NEAR(n(0), 25 * 25, 60) << "one in 8 cm";
  EXPECT_NEAR(n(0) + n(1), 67 * 67, 500) << "one in 3 cm";
}

TEST(PointsItems, FarPointsFit) {
  for (const PageItem& item : points_items(keyframe(100, 90)))
    EXPECT_GE(32767 * item.header["unit"].get<float>(), 90 * 0.999f);
}

Eigen::Vector3f unfolded(int a, int b) {
  Eigen::Vector3f n(static_cast<float>(a) / 127, static_cast<float>(b) / 127, 0);
  n.z() = 1 - std::abs(n.x()) - std::abs(n.y());
  if (n.z() < 0) {
    const Eigen::Vector2f p = n.head<2>();
    n.x() = (1 - std::abs(p.y())) * (p.x() < 0 ? -1.f : 1.f);
    n.y() = (1 - std::abs(p.x())) * (p.y() < 0 ? -1.f : 1.f);
  }
  return n.normalized();
}

Mesh fan(int n) {
  Mesh mesh;
  Random random(3);
  for (int i = 0; i < n; ++i) {
    mesh.vertices.emplace_back(5 + random.uniform(0, 0.64), -3 + random.uniform(0, 0.64),
                               random.uniform(0, 0.3));
    mesh.normals.emplace_back(
        Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized().cast<float>());
    mesh.colours.emplace_back(1, 2, static_cast<uchar>(i));
  }
  for (int i = 0; i + 2 < n; ++i)
    mesh.triangles.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i + 1),
                              static_cast<std::uint32_t>(i + 2)});
  return mesh;
}

TEST(MeshItem, VerticesNormalsColoursAndTrianglesComeBack) {
  const Mesh mesh = fan(101);
  const PageItem item = mesh_item({false, {1, -2, 3}, 1}, mesh);
  EXPECT_EQ(item.key, "1,-2,3");
  const std::size_t n = 101, triangles = 99;
  ASSERT_EQ(item.bytes.size(), (9 * n + 1) / 2 * 2 + 6 * triangles);
  const auto unit = item.header["unit"].get<float>();
  for (std::size_t i = 0; i < n; ++i) {
    const auto packed = number<std::uint32_t>(item.bytes, 4 * i);
    for (int axis = 0; axis < 3; ++axis) {
      const auto steps = static_cast<float>(packed >> (10 * axis) & 1023);
      const float at = item.header["origin"][static_cast<std::size_t>(axis)].get<float>() + unit * steps;
      EXPECT_NEAR(at, mesh.vertices[i][axis], 0.0005);
    }
    const Eigen::Vector3f normal = unfolded(number<std::int8_t>(item.bytes, 4 * n + 2 * i),
                                            number<std::int8_t>(item.bytes, 4 * n + 2 * i + 1));
    EXPECT_GT(normal.dot(mesh.normals[i]), 0.9995f);
    EXPECT_EQ(number<std::uint8_t>(item.bytes, 6 * n + 3 * i), static_cast<std::uint8_t>(i));
  }
  const std::size_t begin = (9 * n + 1) / 2 * 2;
  EXPECT_EQ(number<std::uint16_t>(item.bytes, begin + 6 * 98 + 4), 100);
}

TEST(MeshItem, ManyVerticesHaveWideTriangles) {
  const PageItem item = mesh_item({true, {0, 0, 0}, 1}, fan(70'001));
  const std::size_t begin = (9 * 70'001 + 3) / 4 * 4;
  ASSERT_EQ(item.bytes.size(), begin + 12 * 69'999u);
  EXPECT_EQ(number<std::uint32_t>(item.bytes, item.bytes.size() - 4), 70'000u);
  EXPECT_EQ(item.key, "coarse 0,0,0");
}

Landmark landmark(std::int64_t id, double x, int observations) {
  Landmark l;
  l.id = id;
  l.mean = {x, 1, 2};
  l.covariance << 1, 2, 3, 2, 4, 5, 3, 5, 6;
  l.observations = observations;
  l.colour = {10, 20, 30};
  return l;
}

TEST(LandmarkItems, StandInCubesWithTheirCovariance) {
  const auto items = landmark_items({landmark(1, 0.5, 300), landmark(2, 5, 3), landmark(3, 1, 2)});
  ASSERT_EQ(items.size(), 2u);
  EXPECT_EQ(items[0].key, "0,0,0");
  EXPECT_EQ(items[0].header["n"], 2);
  ASSERT_EQ(items[0].bytes.size(), 88u);
  EXPECT_EQ(number<float>(items[0].bytes, 0), 0.5f);
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_EQ(number<float>(items[0].bytes, 12 + 4 * i), 1.f + static_cast<float>(i));
  EXPECT_EQ(number<std::uint32_t>(items[0].bytes, 36), 1u);
  EXPECT_EQ(number<std::uint8_t>(items[0].bytes, 40), 10);
  EXPECT_EQ(number<std::uint8_t>(items[0].bytes, 43), 255) << "more than a byte holds";
}

TEST(LandmarkItems, OfTooManyThoseSeenMostOftenStay) {
  std::vector<Landmark> many;
  for (int i = 0; i < 100; ++i) many.push_back(landmark(i, 0.5, i));
  const auto items = landmark_items(many, 10);
  ASSERT_EQ(items.size(), 1u);
  EXPECT_EQ(items[0].header["n"], 10);
  EXPECT_EQ(number<std::uint32_t>(items[0].bytes, 36), 90u);
}

TEST(PathItems, AGrownPathChangesItsLastPieceAlone) {
  std::vector<Eigen::Vector3d> path(600, {1, 2, 3});
  const auto before = path_items("icp", path);
  path.emplace_back(4, 5, 6);
  const auto after = path_items("icp", path);
  ASSERT_EQ(after.size(), 2u);
  EXPECT_EQ(after[0].bytes, before[0].bytes);
  EXPECT_EQ(after[1].key, "icp/1");
  EXPECT_EQ(number<float>(after[1].bytes, after[1].bytes.size() - 4), 6.f);
}

TEST(GraphItem, HasNodesAndEdges) {
  const PageItem item = graph_item({{5, planar_pose(1, 2, 0)}}, {{5, 6, 2, 0.5f}});
  ASSERT_EQ(item.bytes.size(), 32u + 16u);
  EXPECT_EQ(number<std::int32_t>(item.bytes, 0), 5);
  EXPECT_EQ(number<float>(item.bytes, 4), 1.f);
  EXPECT_EQ(number<float>(item.bytes, 16), 1.f) << "w of the quaternion";
  EXPECT_EQ(number<std::int32_t>(item.bytes, 32 + 8), 2);
  EXPECT_EQ(number<float>(item.bytes, 32 + 12), 0.5f);
}

TEST(GridItem, CellsAreUnknownFreeOrInTheWay) {
  NavigationGrid grid;
  grid.cell_size = 0.05;
  grid.origin = {-1, -2};
  constexpr std::int8_t u = NavigationGrid::unknown, f = NavigationGrid::free, o = NavigationGrid::occupied;
  grid.cells = (cv::Mat_<std::int8_t>(3, 4) << u, u, u, u, u, f, o, u, u, u, f, u);
  grid.ground = cv::Mat_<float>(3, 4, NAN);
  grid.ground(1, 1) = 0.25f;
  const PageItem item = grid_item(grid);
  EXPECT_EQ(item.bytes, std::string("\1\2\0\1", 4)) << "what is known, and what lies between";
  EXPECT_EQ(item.header["width"], 2);
  EXPECT_EQ(item.header["height"], 2);
  EXPECT_EQ(item.header["origin"], (nlohmann::json{-0.95, -1.95, 0.25}));
}

}  // namespace
}  // namespace lcmslam
