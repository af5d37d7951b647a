#include <lcmslam/live_page/map_items.hpp>

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <map>

#include <lcmslam/cloud/voxel_index.hpp>
#include <lcmslam/planes/objects.hpp>

namespace lcmslam {
namespace {

using nlohmann::json;

constexpr std::size_t poses_per_piece = 512;
constexpr double landmark_cube = 4;  // m

json row(const Eigen::Vector3d& v) {
  return {rounded_for_page(v.x()), rounded_for_page(v.y()), rounded_for_page(v.z())};
}

/// x y z, then w x y z.
json told(const Eigen::Isometry3d& T) {
  const Eigen::Quaterniond q(T.linear());
  json values = row(T.translation());
  for (const double value : {q.w(), q.x(), q.y(), q.z()}) values.push_back(rounded_for_page(value));
  return values;
}

void append_rgb(std::string& bytes, const cv::Vec3b& bgr) {
  for (int i = 2; i >= 0; --i) bytes.push_back(static_cast<char>(bgr[i]));
}

Eigen::Vector3i cell_of(const Eigen::Vector3f& point, float cell) {
  return (point / cell).array().floor().cast<int>();
}

/// The level of each point: the first in its cell takes it.
std::vector<int> levels_of(const std::vector<Eigen::Vector3f>& points) {
  constexpr std::array<float, point_levels - 1> cells = {0.08f, 0.03f};  // m
  std::vector<int> levels(points.size(), point_levels - 1);
  for (int level = point_levels - 2; level >= 0; --level) {
    VoxelIndex taken;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto number = static_cast<std::int32_t>(i);
      const std::uint64_t key = voxel_key(cell_of(points[i], cells[static_cast<std::size_t>(level)]));
      if (taken.insert(key, number) == number) levels[i] = level;
    }
  }
  return levels;
}

/// Octahedral: the unit sphere folded to a square of -127 .. 127 (Meyer et al., "On floating-point normal
/// vectors", 2010).
std::array<std::int8_t, 2> folded(const Eigen::Vector3f& normal) {
  const float length = normal.lpNorm<1>();
  if (!(length > 0)) return {0, 0};
  Eigen::Vector2f p = normal.head<2>() / length;
  if (normal.z() < 0) {
    const Eigen::Vector2f turned = {1 - std::abs(p.y()), 1 - std::abs(p.x())};
    p = {p.x() < 0 ? -turned.x() : turned.x(), p.y() < 0 ? -turned.y() : turned.y()};
  }
  return {static_cast<std::int8_t>(std::lround(127 * p.x())),
          static_cast<std::int8_t>(std::lround(127 * p.y()))};
}

const char* name_of(PlaneLabel label) {
  switch (label) {
    case PlaneLabel::floor:
      return "floor";
    case PlaneLabel::table_top:
      return "table";
    case PlaneLabel::ceiling:
      return "ceiling";
    case PlaneLabel::wall:
      return "wall";
    case PlaneLabel::other:
      break;
  }
  return "other";
}

}  // namespace

std::vector<PageItem> points_items(const DenseKeyframe& keyframe) {
  const ColouredCloud& cloud = keyframe.cloud;
  float reach = 0;
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();
  for (const Eigen::Vector3f& p : cloud.points) {
    reach = std::max(reach, p.cwiseAbs().maxCoeff());
    middle += p / static_cast<float>(cloud.size());
  }
  const float unit = std::max(0.001f, reach / 32767);
  const std::vector<int> levels = levels_of(cloud.points);
  std::vector<PageItem> items;
  for (int level = 0; level < point_levels; ++level) {
    PageItem item{"points", fmt::format("{}/{}", keyframe.id, level)};
    std::string colours;
    int n = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      if (levels[i] != level) continue;
      for (const float x : cloud.points[i])
        append_bytes(item.bytes, static_cast<std::int16_t>(std::lround(x / unit)));
      append_rgb(colours, cloud.colours[i]);
      ++n;
    }
    item.bytes += colours;
    item.header = {{"keyframe", keyframe.id}, {"level", level}, {"n", n}, {"unit", unit}};
    item.header["T"] = told(keyframe.T_world_camera);
    item.place = keyframe.T_world_camera.cast<float>() * middle;
    items.push_back(std::move(item));
  }
  return items;
}

PageItem mesh_item(const MeshCube& cube, const Mesh& mesh) {
  PageItem item{"mesh", fmt::format("{}{},{},{}", cube.is_coarse ? "coarse " : "", cube.at.x(), cube.at.y(),
                                    cube.at.z())};
  if (mesh.triangles.empty()) return item;
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& v : mesh.vertices) box.extend(v);
  const float unit = std::max(box.sizes().maxCoeff() / 1023, 1e-5f);
  std::string normals, colours;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3f at = (mesh.vertices[i] - box.min()) / unit;
    const Eigen::Matrix<std::uint32_t, 3, 1> p = at.array().round().max(0).min(1023).cast<std::uint32_t>();
    append_bytes(item.bytes, p.x() | p.y() << 10 | p.z() << 20);
    for (const std::int8_t n : folded(mesh.normals[i])) append_bytes(normals, n);
    append_rgb(colours, mesh.colours[i]);
  }
  item.bytes += normals + colours;
  if (item.bytes.size() % 2 != 0) item.bytes.push_back(0);
  const bool wide = mesh.vertices.size() > 65536;
  if (wide) item.bytes.resize((item.bytes.size() + 3) / 4 * 4);
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t vertex : triangle) {
      if (wide)
        append_bytes(item.bytes, vertex);
      else
        append_bytes(item.bytes, static_cast<std::uint16_t>(vertex));
    }
  item.header = {
      {"n_vertices", mesh.vertices.size()}, {"n_triangles", mesh.triangles.size()}, {"unit", unit}};
  item.header["origin"] = row(box.min().cast<double>());
  item.place = box.center();
  return item;
}

std::vector<PageItem> landmark_items(std::vector<Landmark> landmarks, std::size_t most) {
  if (landmarks.size() > most) {
    const auto seen_more = [](const Landmark& a, const Landmark& b) {
      return a.observations != b.observations ? a.observations > b.observations : a.id < b.id;
    };
    std::nth_element(landmarks.begin(), landmarks.begin() + static_cast<std::ptrdiff_t>(most),
                     landmarks.end(), seen_more);
    landmarks.resize(most);
    std::sort(landmarks.begin(), landmarks.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  }
  std::map<std::array<int, 3>, PageItem> cubes;
  for (const Landmark& l : landmarks) {
    const Eigen::Vector3i at = (l.mean / landmark_cube).array().floor().cast<int>();
    PageItem& item = cubes[{at.x(), at.y(), at.z()}];
    if (item.channel.empty()) {
      item = {"landmarks", fmt::format("{},{},{}", at.x(), at.y(), at.z())};
      item.header["n"] = 0;
      item.place = static_cast<float>(landmark_cube) * (at.cast<float>() + Eigen::Vector3f::Constant(0.5f));
    }
    for (const double x : l.mean) append_bytes(item.bytes, static_cast<float>(x));
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j) append_bytes(item.bytes, static_cast<float>(l.covariance(i, j)));
    append_bytes(item.bytes, static_cast<std::uint32_t>(l.id));
    for (const std::uint8_t c : l.colour) append_bytes(item.bytes, c);
    append_bytes(item.bytes, static_cast<std::uint8_t>(std::clamp(l.observations, 0, 255)));
    item.header["n"] = item.header["n"].get<int>() + 1;
  }
  std::vector<PageItem> items;
  items.reserve(cubes.size());
  for (auto& cube : cubes) items.push_back(std::move(cube.second));
  return items;
}

std::vector<PageItem> path_items(const std::string& name, const std::vector<Eigen::Vector3d>& path,
                                 std::size_t first) {
  std::vector<PageItem> items;
  for (std::size_t begin = 0; begin < path.size(); begin += poses_per_piece) {
    PageItem item{"path", fmt::format("{}/{}", name, first + items.size())};
    for (std::size_t i = begin; i < std::min(begin + poses_per_piece, path.size()); ++i)
      for (const double x : path[i]) append_bytes(item.bytes, static_cast<float>(x));
    items.push_back(std::move(item));
  }
  return items;
}

PageItem graph_item(const std::vector<KeyframePose>& nodes, const std::vector<PageEdge>& edges) {
  PageItem item{"graph", ""};
  item.header = {{"n_nodes", nodes.size()}, {"n_edges", edges.size()}};
  for (const KeyframePose& node : nodes) {
    append_bytes(item.bytes, node.id);
    const Eigen::Quaterniond q(node.T_world_camera.linear());
    for (const double x : node.T_world_camera.translation()) append_bytes(item.bytes, static_cast<float>(x));
    for (const double x : {q.w(), q.x(), q.y(), q.z()}) append_bytes(item.bytes, static_cast<float>(x));
  }
  for (const PageEdge& edge : edges) {
    append_bytes(item.bytes, edge.from);
    append_bytes(item.bytes, edge.to);
    append_bytes(item.bytes, static_cast<std::int32_t>(edge.kind));
    append_bytes(item.bytes, edge.error);
  }
  return item;
}

PageItem grid_item(const NavigationGrid& grid) {
  cv::Rect known;  // most of a grid is unknown: the rest alone travels
  double ground = 0;
  int free = 0;
  for (int y = 0; y < grid.cells.rows; ++y)
    for (int x = 0; x < grid.cells.cols; ++x) {
      if (grid.cells(y, x) == NavigationGrid::unknown) continue;
      known |= cv::Rect(x, y, 1, 1);
      if (grid.cells(y, x) != NavigationGrid::free || !std::isfinite(grid.ground(y, x))) continue;
      ground += grid.ground(y, x);
      ++free;
    }
  PageItem item{"grid", ""};
  for (int y = known.y; y < known.y + known.height; ++y)
    for (int x = known.x; x < known.x + known.width; ++x) {
      const std::int8_t cell = grid.cells(y, x);
      item.bytes.push_back(cell == NavigationGrid::unknown ? 0 : cell == NavigationGrid::free ? 1 : 2);
    }
  const Eigen::Vector2d origin = grid.origin + grid.cell_size * Eigen::Vector2d(known.x, known.y);
  item.header = {{"cell", grid.cell_size}, {"width", known.width}, {"height", known.height}};
  item.header["origin"] = row({origin.x(), origin.y(), free > 0 ? ground / free : 0});
  return item;
}

PageItem planes_item(const std::vector<PlanePatch>& planes) {
  json all = json::array();
  for (const PlanePatch& patch : planes) {
    json outline = json::array();
    for (const Eigen::Vector3d& corner : patch.outline) outline.push_back(row(corner));
    all.push_back({{"label", name_of(patch.label)},
                   {"outline", outline},
                   {"normal", row(patch.fit.plane.normal)},
                   {"area", rounded_for_page(patch.area)}});
  }
  return {"planes", "", {{"planes", all}}, ""};
}

PageItem objects_item(const std::vector<PlanePatch>& planes, const std::vector<Eigen::Vector3f>& vertices,
                      const ObjectSettings& settings) {
  json objects = json::array();
  for (const PlanePatch& patch : planes) {
    if (patch.label != PlaneLabel::floor && patch.label != PlaneLabel::table_top) continue;
    for (const StandingObject& object : find_objects(vertices, patch, settings)) {
      const Eigen::Quaterniond turn(object.T_map_box.linear());
      objects.push_back({{"centre", row(object.T_map_box.translation())},
                         {"quaternion", {turn.w(), turn.x(), turn.y(), turn.z()}},
                         {"size", row(object.size)},
                         {"on", name_of(patch.label)}});
    }
  }
  return {"objects", "", {{"objects", objects}}, ""};
}

}  // namespace lcmslam
