#include <lcmslam/map_query/question.hpp>

#include <gmock/gmock.h>

namespace lcmslam {
namespace {

using ::testing::HasSubstr;

/// Written and read again, it is written the same.
template <class What>
What returned(const What& what) {
  const std::string json = to_json({what, 2.5});
  const Question question = parse_question(json);
  EXPECT_EQ(to_json(question), json);
  EXPECT_EQ(question.deadline, 2.5);
  return std::get<What>(question.what);
}

TEST(Question, ComesBackAsItWasWritten) {
  EXPECT_EQ(returned(DistanceQuestion{{{1, 2, 3}, {-4, 5, 0.25}}}).points[1].z(), 0.25);
  EXPECT_EQ(returned(SpaceQuestion{{{1, 2, 3}}}).points.size(), 1U);
  const Sphere sphere{{1, 2, 3}, 0.5};
  const Capsule capsule{{1, 2, 3}, {4, 5, 6}, 0.25};
  Box box;
  box.T_map_box = Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ());
  box.half_size = {0.5, 1, 2};
  const auto bodies = returned(CollisionQuestion{{sphere, capsule, box}}).bodies;
  ASSERT_EQ(bodies.size(), 3U);
  EXPECT_EQ(std::get<Capsule>(bodies[1]).to.z(), 6);
  EXPECT_TRUE(std::get<Box>(bodies[2]).T_map_box.isApprox(box.T_map_box, 1e-12));
  EXPECT_EQ(std::get<Box>(bodies[2]).half_size, box.half_size);
  const PathQuestion path = returned(PathQuestion{box, {planar_pose(1, 2, 0.25), planar_pose(3, 4, -0.5)}});
  EXPECT_TRUE(path.T_map_robot[1].isApprox(planar_pose(3, 4, -0.5), 1e-12));
  const Eigen::Isometry3d on_a_ramp =
      planar_pose(1, 2, 0.25) * Eigen::AngleAxisd(0.14, Eigen::Vector3d::UnitY());
  const auto ramp = std::get<PathQuestion>(
      parse_question(to_json({PathQuestion{box, {planar_pose(1, 2, 0.25), on_a_ramp}}, 1})).what);
  ASSERT_EQ(ramp.T_map_robot.size(), 2U);
  EXPECT_TRUE(ramp.T_map_robot[0].isApprox(planar_pose(1, 2, 0.25), 1e-12));
  EXPECT_TRUE(ramp.T_map_robot[1].isApprox(on_a_ramp, 1e-12));
  CloudQuestion cloud;
  cloud.region.sphere = sphere;
  cloud.resolution = 0.125;
  EXPECT_EQ(returned(cloud).region.sphere->radius, 0.5);
  MeshQuestion mesh;
  mesh.region.from = {1, 2, 3};
  mesh.region.to = {4, 5, 6};
  mesh.format = MeshFormat::glb;
  EXPECT_EQ(returned(mesh).region.to, mesh.region.to);
  EXPECT_EQ(returned(mesh).format, MeshFormat::glb);
  PlanesQuestion planes;
  planes.near = Eigen::Vector3d(1, 2, 3);
  planes.supporting = true;
  EXPECT_EQ(*returned(planes).near, *planes.near);
  EXPECT_TRUE(returned(planes).supporting);
  EXPECT_EQ(returned(ObjectsQuestion{planes}).planes.radius, 1);
  EXPECT_FALSE(returned(LandmarksQuestion{}).region.sphere);
  FrontiersQuestion frontiers;
  frontiers.settings.min_cells = 7;
  EXPECT_EQ(returned(frontiers).settings.min_cells, 7);
  returned(GridQuestion{});
  EXPECT_EQ(returned(LocaliseQuestion{1'700'000'000'000'000}).utime, 1'700'000'000'000'000);
}

// Who asks in C++ has one list; JSON has one a kind.
TEST(Question, BodiesOfAllKindsAreAnsweredInAKnownOrder) {
  const Sphere sphere{{1, 2, 3}, 0.5};
  const Capsule capsule{{1, 2, 3}, {4, 5, 6}, 0.25};
  Box box;
  box.half_size = {0.5, 1, 2};
  const std::vector<CollisionQuestion::Body> asked = {box, sphere, capsule, Sphere{{7, 8, 9}, 0.25}};
  EXPECT_THAT(json_order(asked), ::testing::ElementsAre(1, 3, 2, 0));
  const Question read = parse_question(to_json({CollisionQuestion{asked}, 1}));
  const auto& bodies = std::get<CollisionQuestion>(read.what).bodies;
  for (std::size_t i = 0; i < asked.size(); ++i)
    EXPECT_EQ(bodies[i].index(), asked[json_order(asked)[i]].index());
  EXPECT_EQ(std::get<Sphere>(bodies[1]).centre.x(), 7);
}

TEST(Question, RegionsHoldWhatLiesInThem) {
  Region box;
  box.from = {0, 0, 0};
  box.to = {1, 1, 1};
  EXPECT_TRUE(box.contains({1, 0, 0.5}));
  EXPECT_FALSE(box.contains({1.01, 0, 0.5}));
  EXPECT_TRUE(box.reaches({1.5, 0, 0}, 0.5));
  EXPECT_FALSE(box.reaches({1.6, 0, 0}, 0.5));
  Region sphere;
  sphere.sphere = Sphere{{0, 0, 0}, 1};
  EXPECT_TRUE(sphere.contains({0.7, 0.7, 0}));
  EXPECT_FALSE(sphere.contains({0.8, 0.8, 0}));
  EXPECT_TRUE(Region().contains({-1e5, 3, 4}));
}

TEST(Question, WhatIsWrongIsSaid) {
  const auto problem = [](const std::string& json) -> std::string {
    try {
      parse_question(json);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(problem("[1"), HasSubstr("JSON"));
  EXPECT_THAT(problem("[1]"), HasSubstr("an object"));
  EXPECT_THAT(problem("{}"), HasSubstr("'ask' is missing"));
  EXPECT_THAT(problem(R"({"ask": 3})"), HasSubstr("must be a text"));
  EXPECT_THAT(problem(R"({"ask": "grid", "deadline": 0})"),
              HasSubstr("'deadline' is 0, must be a number from"));
  EXPECT_THAT(problem(R"({"ask": "space", "points": []})"), HasSubstr("1 to 20000 rows of 3"));
  EXPECT_THAT(problem(R"({"ask": "space", "points": [[1, 2, "x"]]})"), HasSubstr("3 numbers"));
  EXPECT_THAT(problem(R"({"ask": "space", "points": [[1, 2, 1e9]]})"), HasSubstr("within 1e6"));
  EXPECT_THAT(problem(R"({"ask": "collision"})"), HasSubstr("'spheres', 'capsules' or 'boxes'"));
  EXPECT_THAT(problem(R"({"ask": "collision", "spheres": [[0, 0, 0, 0]]})"), HasSubstr("must be above 0"));
  EXPECT_THAT(problem(R"({"ask": "collision", "boxes": [[0, 0, 0, 1, 1, 0, 0, 1, 1, 1]]})"),
              HasSubstr("must be 1"));
  EXPECT_THAT(problem(R"({"ask": "cloud", "from": [1, 0, 0], "to": [0, 1, 1]})"), HasSubstr("not be above"));
  EXPECT_THAT(problem(R"({"ask": "cloud", "from": [0, 0, 0]})"), HasSubstr("'to' is missing"));
  EXPECT_THAT(problem(R"({"ask": "mesh", "format": "stl"})"), HasSubstr("ply"));
  EXPECT_THAT(problem(R"({"ask": "frontiers", "lowest": 2, "highest": 1})"),
              HasSubstr("'highest' must be above"));
  EXPECT_THAT(problem(R"({"ask": "planes", "supporting": 1})"), HasSubstr("true or false"));
  EXPECT_THAT(problem(R"({"ask": "planes", "suporting": true})"), HasSubstr("suporting"));
  EXPECT_EQ(problem(R"({"ask": "planes"})"), "");
}

// A robot in mm would have empty space divided for minutes, while nothing is mapped.
TEST(Question, BodiesAreNoLargerThanRobots) {
  for (const std::string body :
       {R"("ask": "path", "robot": [0, 0, 700, 1, 0, 0, 0, 750, 550, 1400], "poses": [[0, 0, 0, 0]])",
        R"("ask": "collision", "spheres": [[0, 0, 0, 0.2], [0, 0, 0, 200]])",
        R"("ask": "collision", "capsules": [[0, 0, 0, 100, 0, 0, 0.1]])",
        R"("ask": "collision", "boxes": [[0, 0, 0, 1, 0, 0, 0, 1, 1, 31]])"}) {
    try {
      parse_question("{" + body + "}");
      ADD_FAILURE() << body;
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr("all lengths are in m"));
    }
  }
}

TEST(Question, ListsThatNestDeepAreRefused) {
  const std::string deep(200'000, '[');
  EXPECT_THROW(parse_question(R"({"ask": )" + deep + std::string(200'000, ']') + "}"), std::invalid_argument);
  EXPECT_THROW(parse_question(R"({"ask": )" + deep), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
