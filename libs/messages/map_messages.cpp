#include <lcmslam/messages/map_messages.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/messages/geometry_messages.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t landmark_bytes = 136;       // landmark_t on the wire
constexpr std::size_t keyframe_point_bytes = 12;  // 3 x int16 position, 3 bytes colour, 3 bytes normal
constexpr int most_tiles = 100'000;

void append(keyframe_t& m, const ColouredCloud& cloud, std::size_t i) {
  for (int k = 0; k < 3; ++k) {
    const double units = static_cast<double>(cloud.points[i](k)) / m.resolution;
    const float n = cloud.normals.empty() ? 0.F : cloud.normals[i](k);
    const float n127 = std::isfinite(n) ? 127 * std::clamp(n, -1.F, 1.F) : 0.F;
    m.position.push_back(static_cast<std::int16_t>(std::lround(units)));
    m.colour.push_back(cloud.colours[i][2 - k]);
    m.normal.push_back(static_cast<std::int8_t>(std::lround(n127)));
  }
}

bool fits(const Eigen::Vector3f& point, double resolution) {
  return point.allFinite() && point.cwiseAbs().maxCoeff() < static_cast<float>(32'000 * resolution);
}

}  // namespace

landmark_t to_message(const Landmark& landmark) {
  landmark_t m;
  m.id = landmark.id;
  const Eigen::Matrix3d& S = landmark.covariance;
  const double upper[6] = {S(0, 0), S(0, 1), S(0, 2), S(1, 1), S(1, 2), S(2, 2)};
  for (int i = 0; i < 3; ++i) m.mean[i] = landmark.mean(i);
  for (int i = 0; i < 6; ++i) m.covariance[i] = static_cast<float>(upper[i]);
  m.observations = landmark.observations;
  m.existence = static_cast<float>(landmark.log_odds);
  m.laplacian = landmark.laplacian;
  std::copy(landmark.colour.begin(), landmark.colour.end(), m.colour);
  std::copy(landmark.descriptor.begin(), landmark.descriptor.end(), m.descriptor);
  return m;
}

std::vector<landmarks_t> make_landmark_tiles(Utime utime, std::int64_t revision, std::int64_t base_revision,
                                             const std::vector<Landmark>& landmarks,
                                             const std::vector<std::int64_t>& removed) {
  constexpr std::size_t per_tile = tile_bytes / landmark_bytes;
  const std::size_t tiles =
      std::max<std::size_t>(1, (landmarks.size() + removed.size() / 16 + per_tile - 1) / per_tile);
  std::vector<landmarks_t> messages(tiles);
  const auto share = [&](std::size_t total, std::size_t k) { return total * k / tiles; };
  for (std::size_t k = 0; k < tiles; ++k) {
    landmarks_t& m = messages[k];
    m.utime = utime;
    m.frame = "map";
    m.map_revision = revision;
    m.base_revision = base_revision;
    m.tile = static_cast<int32_t>(k);
    m.n_tiles = static_cast<int32_t>(tiles);
    for (std::size_t i = share(landmarks.size(), k); i < share(landmarks.size(), k + 1); ++i)
      m.landmarks.push_back(to_message(landmarks[i]));
    m.removed.assign(removed.begin() + static_cast<std::ptrdiff_t>(share(removed.size(), k)),
                     removed.begin() + static_cast<std::ptrdiff_t>(share(removed.size(), k + 1)));
    m.n_landmarks = static_cast<int32_t>(m.landmarks.size());
    m.n_removed = static_cast<int32_t>(m.removed.size());
  }
  return messages;
}

std::vector<Landmark> landmarks_of(const landmarks_t& message) {
  check_range(message.n_tiles, 1, most_tiles, "n_tiles");
  check_range(message.tile, 0, message.n_tiles - 1, "tile");
  std::vector<Landmark> landmarks;
  landmarks.reserve(message.landmarks.size());
  for (const landmark_t& m : message.landmarks) {
    for (const double v : m.mean) check_range(v, -largest_coordinate, largest_coordinate, "landmark mean");
    for (const float v : m.covariance) check_range(v, -1e12, 1e12, "landmark covariance");
    check_range(m.existence, -1e12, 1e12, "landmark existence");
    Landmark landmark;
    landmark.id = m.id;
    landmark.mean = Eigen::Vector3d(m.mean[0], m.mean[1], m.mean[2]);
    const float* c = m.covariance;
    landmark.covariance << c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5];
    landmark.observations = m.observations;
    landmark.log_odds = m.existence;
    std::copy(std::begin(m.colour), std::end(m.colour), landmark.colour.begin());
    std::copy(std::begin(m.descriptor), std::end(m.descriptor), landmark.descriptor.begin());
    landmark.laplacian = m.laplacian;
    landmarks.push_back(landmark);
  }
  return landmarks;
}

std::vector<keyframe_t> make_keyframe_tiles(const DenseKeyframe& keyframe,
                                            const Eigen::Isometry3d& T_robot_camera, std::int64_t revision) {
  constexpr double resolution = 0.001;  // m
  constexpr std::size_t per_tile = tile_bytes / keyframe_point_bytes;
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < keyframe.cloud.size(); ++i)
    if (fits(keyframe.cloud.points[i], resolution)) chosen.push_back(i);

  const std::size_t tiles = std::max<std::size_t>(1, (chosen.size() + per_tile - 1) / per_tile);
  std::vector<keyframe_t> messages(tiles);
  for (std::size_t k = 0; k < tiles; ++k) {
    keyframe_t& m = messages[k];
    m.utime = keyframe.utime;
    m.frame = "map";
    m.map_revision = revision;
    m.id = keyframe.id;
    m.tile = static_cast<int32_t>(k);
    m.n_tiles = static_cast<int32_t>(tiles);
    m.T_map_camera = to_message(keyframe.T_world_camera);
    m.T_robot_camera = to_message(T_robot_camera);
    m.resolution = resolution;
    for (std::size_t j = chosen.size() * k / tiles; j < chosen.size() * (k + 1) / tiles; ++j)
      append(m, keyframe.cloud, chosen[j]);
    m.n_values = static_cast<int32_t>(m.position.size());
  }
  return messages;
}

KeyframeTile from_message(const keyframe_t& message) {
  check_range(message.n_tiles, 1, most_tiles, "n_tiles");
  check_range(message.tile, 0, message.n_tiles - 1, "tile");
  check_range(message.resolution, 1e-6, 1, "resolution");
  if (message.n_values % 3 != 0) throw DecodeError("n_values is no multiple of 3");
  KeyframeTile tile;
  tile.tile = message.tile;
  tile.tiles = message.n_tiles;
  tile.part.id = message.id;
  tile.part.utime = message.utime;
  tile.part.revision = message.map_revision;
  tile.part.T_world_camera = from_message(message.T_map_camera, "T_map_camera");
  const auto resolution = static_cast<float>(message.resolution);
  for (std::size_t i = 0; i < message.position.size(); i += 3) {
    const auto* p = &message.position[i];
    const auto* c = &message.colour[i];
    const Eigen::Vector3f normal(message.normal[i], message.normal[i + 1], message.normal[i + 2]);
    tile.part.cloud.points.emplace_back(resolution * p[0], resolution * p[1], resolution * p[2]);
    tile.part.cloud.colours.emplace_back(c[2], c[1], c[0]);
    tile.part.cloud.normals.push_back(normal.isZero() ? Eigen::Vector3f::Constant(std::nanf(""))
                                                      : normal.normalized());
  }
  return tile;
}

std::vector<KeyframePose> from_message(const graph_t& message) {
  std::vector<KeyframePose> poses;
  for (const graph_node_t& node : message.nodes)
    poses.push_back({node.keyframe, from_message(node.T_map_camera, "T_map_camera")});
  return poses;
}

node_covariance_t to_message(std::int32_t id, const Matrix6d& covariance) {
  node_covariance_t m;
  m.keyframe = id;
  float* value = m.covariance;
  for (int row = 0; row < 6; ++row)
    for (int column = row; column < 6; ++column) *value++ = static_cast<float>(covariance(row, column));
  return m;
}

Matrix6d from_message(const node_covariance_t& message) {
  for (const float v : message.covariance) check_range(v, -1e12, 1e12, "node covariance");
  Matrix6d covariance;
  const float* value = message.covariance;
  for (int row = 0; row < 6; ++row)
    for (int column = row; column < 6; ++column) covariance(row, column) = covariance(column, row) = *value++;
  if (covariance.diagonal().minCoeff() < 0) throw DecodeError("node covariance: a variance is negative");
  return covariance;
}

}  // namespace lcmslam
