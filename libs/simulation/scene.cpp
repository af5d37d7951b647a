#include <lcmslam/simulation/scene.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/simulation/scene_materials.hpp>
#include <lcmslam/simulation/shapes.hpp>

namespace lcmslam {
namespace {

using Eigen::Isometry3f;
using Eigen::Vector3f;

constexpr double degree = M_PI / 180;
constexpr Range extent{0.001, 100};

Vector3f vector3(const std::vector<double>& values) {
  return {static_cast<float>(values[0]), static_cast<float>(values[1]), static_cast<float>(values[2])};
}

/// Reads one scene file: materials first, then everything that refers to them.
class SceneReader {
 public:
  explicit SceneReader(const ConfigNode& config) : builder_(scene_.triangles), materials_(scene_.materials) {
    scene_.name = config.text("name");
    for (const ConfigNode& node : config.sections("materials")) materials_.read(node);
    if (config.sections("rooms").empty()) config.fail("rooms", "a scene needs at least one room");
    for (const ConfigNode& node : config.sections("rooms")) read_room(node);
    builder_.kind = SurfaceKind::floor;
    std::vector<GroundProfile> ground;
    for (const ConfigNode& node : config.sections("ground")) ground.push_back(read_ground(node));
    scene_.ground = Ground(std::move(ground));
    builder_.kind = SurfaceKind::wall;
    for (const ConfigNode& node : config.sections("partitions")) read_box(node);
    builder_.kind = SurfaceKind::object;
    for (const ConfigNode& node : config.sections("boxes")) read_box(node);
    for (const ConfigNode& node : config.sections("cylinders")) read_cylinder(node);
    for (const ConfigNode& node : config.sections("panels")) read_panel(node);
    for (const ConfigNode& node : config.sections("meshes")) read_mesh(node);
    scene_.ambient = static_cast<float>(config.get("ambient", 0.5, {0, 2}));
    for (const ConfigNode& node : config.sections("lights"))
      scene_.lights.push_back(
          {vector3(node.numbers("position", 3)), static_cast<float>(node.number("power", {0, 100}))});
    read_head(config.section("head"));
    scene_.path = read_points(config, "path", 2);
    scene_.way_back = read_points(config, "way_back", 0);
    config.finish();
  }

  Scene take() { return std::move(scene_); }

 private:
  void read_room(const ConfigNode& node);
  GroundProfile read_ground(const ConfigNode& node);
  void read_box(const ConfigNode& node);
  void read_cylinder(const ConfigNode& node);
  void read_panel(const ConfigNode& node);
  void read_mesh(const ConfigNode& node);
  void read_head(const ConfigNode& node);
  std::vector<Eigen::Vector2d> read_points(const ConfigNode& node, const std::string& key, std::size_t least);

  FaceMaterial material(const ConfigNode& node, const std::string& key, const std::string& fallback = "") {
    return materials_.of(node, key, fallback);
  }
  /// Pose of an object's own frame: `at` (base centre), `yaw`, `pitch`, `roll` in degrees.
  Isometry3f pose(const ConfigNode& node);
  /// Calls place(offset) for each copy: `copies` of them, `step` apart in the object's frame.
  template <class Place>
  void repeat(const ConfigNode& node, Place place);

  Scene scene_;
  ShapeBuilder builder_;
  SceneMaterials materials_;
};

Isometry3f SceneReader::pose(const ConfigNode& node) {
  const std::vector<double> at = node.numbers("at", 3);
  const auto angle = [&](const char* key) {
    return static_cast<float>(node.get(key, 0.0, {-360, 360}) * degree);
  };
  Isometry3f T = Isometry3f::Identity();
  T.translation() = vector3(at);
  T.linear() = (Eigen::AngleAxisf(angle("yaw"), Vector3f::UnitZ()) *
                Eigen::AngleAxisf(angle("pitch"), Vector3f::UnitY()) *
                Eigen::AngleAxisf(angle("roll"), Vector3f::UnitX()))
                   .toRotationMatrix();
  return T;
}

template <class Place>
void SceneReader::repeat(const ConfigNode& node, Place place) {
  const int copies = node.get("copies", 1, {1, 1000});
  const std::vector<double> step = copies > 1 ? node.numbers("step", 3) : std::vector<double>{0, 0, 0};
  const Isometry3f T = pose(node);
  for (int i = 0; i < copies; ++i) place(T * Eigen::Translation3f(static_cast<float>(i) * vector3(step)));
}

/// A rectangle seen from inside: floor, ceiling and four walls.
void SceneReader::read_room(const ConfigNode& node) {
  const std::vector<double> low = node.numbers("from", 2), high = node.numbers("to", 2);
  const auto height = static_cast<float>(node.get("height", 2.6, {2, 20}));
  if (!(low[0] < high[0] && low[1] < high[1]))
    node.fail("to", "must be larger than 'from' in both coordinates");
  const auto x0 = static_cast<float>(low[0]), y0 = static_cast<float>(low[1]);
  const float dx = static_cast<float>(high[0]) - x0, dy = static_cast<float>(high[1]) - y0;
  const Vector3f down(0, 0, -height);
  builder_.kind = SurfaceKind::wall;
  builder_.quad({x0 + dx, y0 + dy, height}, {0, -dy, 0}, down, material(node, "east", node.text("walls")));
  builder_.quad({x0, y0 + dy, height}, {dx, 0, 0}, down, material(node, "north", node.text("walls")));
  builder_.quad({x0, y0, height}, {0, dy, 0}, down, material(node, "west", node.text("walls")));
  builder_.quad({x0 + dx, y0, height}, {-dx, 0, 0}, down, material(node, "south", node.text("walls")));
  builder_.kind = SurfaceKind::floor;
  builder_.quad({x0, y0 + dy, 0}, {dx, 0, 0}, {0, -dy, 0}, material(node, "floor"));
  builder_.kind = SurfaceKind::ceiling;
  builder_.quad({x0, y0, height}, {dx, 0, 0}, {0, dy, 0}, material(node, "ceiling"));
}

/// A ramp, a sill, a carpet: `profile` from `at` on along `yaw`, and its flanks down to the floor.
GroundProfile SceneReader::read_ground(const ConfigNode& node) {
  const std::vector<double> at = node.numbers("at", 2);
  GroundProfile ground;
  ground.T_world_profile.translation() << at[0], at[1];
  const double yaw = node.get("yaw", 0.0, {-360, 360}) * degree;
  ground.T_world_profile.linear() = Eigen::Rotation2Dd(yaw).toRotationMatrix();
  ground.width = node.number("width", extent);
  ground.points = read_points(node, "profile", 2);
  std::vector<Vector3f> vertices;  // by fours: left and right, above and on the floor
  std::vector<int> corners;
  const auto triangle = [&](int a, int b, int c) {
    const auto corner = [&](int i) { return vertices[static_cast<std::size_t>(i)]; };
    if (!((corner(b) - corner(a)).cross(corner(c) - corner(a)).norm() > 0))
      return;  // where it lies on the floor
    corners.insert(corners.end(), {a, b, c});
  };
  const auto quad = [&](int a, int b, int c, int d) {
    triangle(a, b, c);
    triangle(a, c, d);
  };
  for (const Eigen::Vector2d& point : ground.points) {
    if (!vertices.empty() && !(point.x() - ground.points[vertices.size() / 4 - 1].x() > 1e-4))
      node.fail("profile", "must be way and height in m for each point, the way ascending");
    if (!(point.y() >= 0 && point.y() < 1)) node.fail("profile", "heights must be from 0 to 1 m");
    const auto x = static_cast<float>(point.x()), z = static_cast<float>(point.y());
    const auto half = static_cast<float>(ground.width / 2);
    const auto k = static_cast<int>(vertices.size());
    for (const float y : {half, -half})
      for (const float height : {z, 0.f}) vertices.emplace_back(x, y, height);
    if (k == 0) continue;
    quad(k - 4, k - 2, k + 2, k);      // above
    quad(k - 4, k, k + 1, k - 3);      // left
    quad(k - 2, k - 1, k + 3, k + 2);  // right
  }
  const auto last = static_cast<int>(vertices.size()) - 4;
  quad(0, 1, 3, 2);
  quad(last, last + 2, last + 3, last + 1);
  Isometry3f T = Isometry3f::Identity();
  T.translation() << static_cast<float>(at[0]), static_cast<float>(at[1]), 0;
  T.rotate(Eigen::AngleAxisf(static_cast<float>(yaw), Vector3f::UnitZ()));
  builder_.mesh(T, vertices, corners, material(node, "material"));
  return ground;
}

void SceneReader::read_box(const ConfigNode& node) {
  const Vector3f size = vector3(node.numbers("size", 3));
  if (!(size.minCoeff() > 0)) node.fail("size", "must be three lengths above 0 m");
  const std::string base = node.text("material");
  std::array<FaceMaterial, 6> faces;
  const char* names[6] = {"front", "left", "back", "right", "top", "bottom"};
  for (std::size_t i = 0; i < 6; ++i) faces[i] = material(node, names[i], base);
  repeat(node, [&](const Isometry3f& T) { builder_.box(T, size, faces); });
}

void SceneReader::read_cylinder(const ConfigNode& node) {
  const auto radius = static_cast<float>(node.number("radius", {0, 10}));
  const auto top = static_cast<float>(node.get("top_radius", static_cast<double>(radius), {0, 10}));
  const auto height = static_cast<float>(node.number("height", extent));
  if (!(radius > 0 || top > 0)) node.fail("radius", "radius or top_radius must be above 0 m");
  const bool lids = node.get("lids", true);
  const FaceMaterial side = material(node, "material"), lid = material(node, "lid", node.text("material"));
  repeat(node, [&](const Isometry3f& T) { builder_.cylinder(T, radius, top, height, lids, side, lid); });
}

/// A flat picture: `at` is the middle of its lower edge, it looks along x of its own frame.
void SceneReader::read_panel(const ConfigNode& node) {
  const std::vector<double> size = node.numbers("size", 2);
  if (!(size[0] > 0 && size[1] > 0)) node.fail("size", "must be width and height above 0 m");
  const auto width = static_cast<float>(size[0]), height = static_cast<float>(size[1]);
  const FaceMaterial face = material(node, "material");
  repeat(node, [&](const Isometry3f& T) {
    builder_.quad(T * Vector3f(0, -width / 2, height), T.linear() * Vector3f(0, width, 0),
                  T.linear() * Vector3f(0, 0, -height), face);
  });
}

void SceneReader::read_mesh(const ConfigNode& node) {
  const std::vector<double> numbers = node.get("vertices", std::vector<double>{});
  const std::vector<double> indices = node.get("triangles", std::vector<double>{});
  if (numbers.empty() || numbers.size() % 3) node.fail("vertices", "must be x, y, z for each vertex");
  if (indices.empty() || indices.size() % 3)
    node.fail("triangles", "must be three vertex numbers for each triangle");
  std::vector<Vector3f> vertices;
  for (std::size_t i = 0; i < numbers.size(); i += 3)
    vertices.push_back(vector3({numbers[i], numbers[i + 1], numbers[i + 2]}));
  std::vector<int> corners;
  for (const double index : indices) {
    if (!(index >= 0 && index < static_cast<double>(vertices.size()) && index == std::floor(index)))
      node.fail("triangles",
                "vertex numbers must be whole, from 0 to " + std::to_string(vertices.size() - 1));
    corners.push_back(static_cast<int>(index));
  }
  const FaceMaterial face = material(node, "material");
  repeat(node, [&](const Isometry3f& T) { builder_.mesh(T, vertices, corners, face); });
}

void SceneReader::read_head(const ConfigNode& node) {
  scene_.head.forward = node.get("forward", scene_.head.forward, {-1, 1});
  scene_.head.height = node.get("height", scene_.head.height, {0.1, 3});
  scene_.head.tilt = node.get("tilt", scene_.head.tilt / degree, {-90, 90}) * degree;
  scene_.head.pan = node.get("pan", 0.0, {-180, 180}) * degree;
}

std::vector<Eigen::Vector2d> SceneReader::read_points(const ConfigNode& config, const std::string& key,
                                                      std::size_t least) {
  const std::vector<double> numbers = config.get(key, std::vector<double>{});
  if (numbers.size() < 2 * least || numbers.size() % 2)
    config.fail(key, "must be x, y in m for each control point, of which there are at least " +
                         std::to_string(least));
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < numbers.size(); i += 2) points.emplace_back(numbers[i], numbers[i + 1]);
  return points;
}

}  // namespace

Scene load_scene(const std::filesystem::path& file) {
  return read_scene(ConfigNode::load(file));
}

Scene read_scene(const ConfigNode& config) {
  return SceneReader(config).take();
}

std::vector<Eigen::Vector2d> control_points(const Scene& scene, int laps) {
  if (laps > 1 && scene.way_back.empty())
    throw std::invalid_argument("scene '" + scene.name + "' has no way_back, which " + std::to_string(laps) +
                                " laps need");
  std::vector<Eigen::Vector2d> points = scene.path;
  for (int lap = 1; lap < laps; ++lap) {
    points.insert(points.end(), scene.way_back.begin(), scene.way_back.end());
    points.insert(points.end(), scene.path.begin(), scene.path.end());
  }
  return points;
}

}  // namespace lcmslam
