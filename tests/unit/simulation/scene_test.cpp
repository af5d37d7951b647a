#include <lcmslam/simulation/scene.hpp>

#include <gmock/gmock.h>

#include <fstream>

#include <lcmslam/simulation/ray_caster.hpp>
#include "tests/unit/simulation/box_room.hpp"

namespace lcmslam {
namespace {

const char* const good = R"(name: test
materials:
  - {name: wall, colour: [128, 128, 128]}
rooms:
  - {from: [0, 0], to: [4, 3], walls: wall, floor: wall, ceiling: wall}
boxes:
  - {at: [2, 1, 0], size: [0.4, 0.6, 0.8], material: wall}
path: [1, 1, 2, 2]
)";

std::string error_of(const std::string& text) {
  try {
    read_scene(ConfigNode::parse(text, "bad.yaml"));
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos);
  return text.replace(at, what.size(), by);
}

TEST(Scene, ReadsWhatTheFileSays) {
  const Scene scene = read_scene(ConfigNode::parse(good));
  EXPECT_EQ(scene.name, "test");
  EXPECT_EQ(scene.triangles.size(), 6u * 2 + 6 * 2);
  EXPECT_EQ(scene.path.size(), 2u);
  const RayCaster caster(scene);
  EXPECT_NEAR(caster.cast({1, 1, 0.5f}, {1, 0, 0}), 0.8, 1e-5);   // the box's side
  EXPECT_NEAR(caster.cast({1, 1, 1.5f}, {1, 0, 0}), 3.0, 1e-5);   // above it: the wall
  EXPECT_NEAR(caster.cast({1, 1, 1.5f}, {0, 0, -1}), 1.5, 1e-5);  // the floor
}

TEST(Scene, ErrorsNameFileAndLine) {
  using testing::AllOf;
  using testing::HasSubstr;
  const std::string box = "material: wall}\npath";
  EXPECT_THAT(error_of(replaced(good, box, "material: wal}\npath")),
              AllOf(HasSubstr("bad.yaml:7"), HasSubstr("'wal'"), HasSubstr("wall")));
  EXPECT_THAT(error_of(replaced(good, "size:", "sise:")), HasSubstr("bad.yaml:7"));
  EXPECT_THAT(error_of(replaced(good, "[0.4, 0.6, 0.8]", "[0.4, 0, 0.8]")), HasSubstr("bad.yaml:7"));
  EXPECT_THAT(error_of(replaced(good, "[128, 128, 128]", "[128, 128]")), HasSubstr("bad.yaml:3"));
  EXPECT_THAT(error_of(replaced(good, "[128, 128, 128]", "[128, 300, 0]")), HasSubstr("bad.yaml:3"));
  EXPECT_THAT(error_of(replaced(good, "colour", "kind: marble, colour")),
              AllOf(HasSubstr("bad.yaml:3"), HasSubstr("marble")));
  EXPECT_THAT(error_of(replaced(good, "to: [4, 3]", "to: [-4, 3]")), HasSubstr("bad.yaml:5"));
  EXPECT_THAT(error_of(replaced(good, "[1, 1, 2, 2]", "[1, 1, 2]")), HasSubstr("bad.yaml:8"));
  EXPECT_THAT(error_of(std::string(good) + "lamps: 3\n"), AllOf(HasSubstr("bad.yaml:9"), HasSubstr("lamps")));
  EXPECT_THAT(
      error_of(std::string(good) + "meshes: [{at: [0, 0, 0], material: wall, vertices: [0, 0, 0, 1, 0, 0, 0, "
                                   "1, 0], triangles: [0, 1, 3]}]\n"),
      AllOf(HasSubstr("bad.yaml:9"), HasSubstr("0 to 2")));
  EXPECT_THROW(load_scene("/nowhere/scene.yaml"), ConfigError);
}

TEST(Scene, MeshesAndCylindersStandWhereTheyAreSaid) {
  const Scene scene = box_room(5,
                               "cylinders: [{at: [2, 0, 0], radius: 0.5, height: 2, material: red}]\n"
                               "meshes: [{at: [-1, 0, 1], material: red, vertices: [0, -1, -1, 0, 1, -1, 0, "
                               "0, 1], triangles: [0, 1, 2]}]\n");
  const RayCaster caster(scene);
  EXPECT_NEAR(caster.cast({0, 0, 1}, {1, 0, 0}), 1.5, 0.01);
  EXPECT_NEAR(caster.cast({0, 0, 1}, {-1, 0, 0}), 1.0, 1e-5);
  EXPECT_NEAR(caster.cast({0, 0, 2.5}, {1, 0, 0}), 5.0, 1e-5);
}

TEST(RayCaster, DistanceToTheNearestSurface) {
  const Scene scene = box_room(5, "boxes: [{at: [2, 0, 1], size: [1, 1, 1], material: red}]\n");
  const RayCaster caster(scene);
  EXPECT_NEAR(caster.distance({1.2, 0, 1.5}), 0.3, 1e-6);                // face
  EXPECT_NEAR(caster.distance({1.2, -0.9, 1.5}), 0.5, 1e-6);             // edge: 0.3, 0.4
  EXPECT_NEAR(caster.distance({1.3, 0.6, 2.2}), std::sqrt(0.09), 1e-6);  // corner: 0.2, 0.1, 0.2
  EXPECT_NEAR(caster.distance({4.9, 3, 1.5}), 0.1, 1e-6);                // wall
  EXPECT_NEAR(caster.distance({4, 3, -0.2}), 0.2, 1e-6);                 // below the floor
}

TEST(Texture, SamplesBilinearlyAndRepeats) {
  cv::Mat image(2, 2, CV_8UC4, cv::Scalar(0, 0, 0, 0));
  image.at<cv::Vec4b>(0, 1) = {200, 0, 0, 100};
  const Texture texture(image, {1, 1});
  EXPECT_NEAR(texture.sample({0.75f, 0.25f}, 0)[0], 200, 1e-3);
  EXPECT_NEAR(texture.sample({0.5f, 0.25f}, 0)[0], 100, 1e-3);
  EXPECT_NEAR(texture.sample({3.75f, -1.75f}, 0)[0], 200, 1e-3);
  EXPECT_NEAR(texture.sample({0.1f, 0.9f}, 5)[3], 25, 1e-3);  // far away: the mean
}

TEST(PixelNoise, IsStandardNormalAndUncorrelated) {
  const PixelNoise noise(1, 2, 3);
  std::vector<double> values, products;
  for (std::uint64_t i = 0; i < 200000; ++i) {
    values.push_back(PixelNoise::smooth_normal(noise.bits(i)));
    products.push_back(values.back() * PixelNoise::smooth_normal(noise.bits(i + 1)));
  }
  EXPECT_NEAR(moments(values).mean, 0, 0.01);
  EXPECT_NEAR(moments(values).deviation, 1, 0.01);
  EXPECT_NEAR(moments(products).mean, 0, 0.01);
  EXPECT_NE(noise.bits(0), PixelNoise(1, 2, 4).bits(0));
  EXPECT_NE(noise.bits(0), PixelNoise(2, 2, 3).bits(0));
}

}  // namespace
}  // namespace lcmslam
