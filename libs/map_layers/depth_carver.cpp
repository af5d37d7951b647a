#include <lcmslam/map_layers/depth_carver.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr float nearest_cell = 0.05f;  // m along the axis: what is nearer has no pixel to speak of

int floor_of(float x) {
  const int cut = static_cast<int>(x);
  return cut - (x < static_cast<float>(cut) ? 1 : 0);
}

/// An image of nearest depths.
struct DepthPlane {
  const float* depth;
  int pitch;  // floats
  float width, height, fx, fy, cx, cy;
};

/// A block's cells in the camera's frame: the first one's centre, and what the others add to it.
struct ProjectedBlock {
  float x, y, z;
  const float *dx, *dy, *dz;
  float margin, slack, max_range;
};

// Which cells of a block every pixel on them that has depth sees through.
LCMSLAM_VECTORISED(see_through, (const ProjectedBlock& block, const DepthPlane& plane, std::uint8_t* through),
                   (block, plane, through)) {
  const float* dx = block.dx;
  const float* dy = block.dy;
  const float* dz = block.dz;
  const float* depth = plane.depth;
  const float x0 = block.x, y0 = block.y, z0 = block.z;
  const float margin = block.margin, slack = block.slack, max_range = block.max_range;
  const float fx = plane.fx, fy = plane.fy, cx = plane.cx + 0.5f, cy = plane.cy + 0.5f;
  const float width = plane.width, height = plane.height;
  const int pitch = plane.pitch;
  std::uint8_t passed[block_cells];  // nobody else's address: the loop is vectorised
  for (int i = 0; i < block_cells; ++i) {
    const float z = z0 + dz[i];
    const float inverse = 1.0f / std::max(z, nearest_cell);
    const float u = (x0 + dx[i]) * fx * inverse + cx;
    const float v = (y0 + dy[i]) * fy * inverse + cy;
    const int column = static_cast<int>(std::min(std::max(u, 0.0f), width - 1));
    const int row = static_cast<int>(std::min(std::max(v, 0.0f), height - 1));
    const float seen = depth[row * pitch + column];
    const bool inside = (u >= 0) & (u < width) & (v >= 0) & (v < height) & (z > nearest_cell);
    passed[i] = static_cast<std::uint8_t>(inside & (z < max_range) & (seen > z + margin + slack * z * z));
  }
  std::copy(passed, passed + block_cells, through);
}

LCMSLAM_VECTORISED(count_misses,
                   (LogOdds * cells, const std::uint8_t* through, const std::uint8_t* hit, int step,
                    int least),
                   (cells, through, hit, step, least)) {
  for (int i = 0; i < block_cells; ++i) {
    const int before = cells[i] == unknown_log_odds ? 0 : cells[i];
    const int after = std::max(before + step, least);
    cells[i] = static_cast<LogOdds>((through[i] != 0) & (hit[i] == 0) ? after : cells[i]);
  }
}

}  // namespace

struct DepthCarver::Seeing {
  const OccupancySettings& settings;
  float cell_size;
  Eigen::Isometry3f T_map_camera, T_camera_map;
  std::array<std::array<float, block_cells>, 3> offset;  // of a block's cells from its first, camera frame

  Seeing(const OccupancyGrid& grid, const Eigen::Isometry3d& T)
      : settings(grid.settings()),
        cell_size(grid.cell_size()),
        T_map_camera(T.cast<float>()),
        T_camera_map(T.inverse().cast<float>()) {
    for (int i = 0; i < block_cells; ++i) {
      const Eigen::Vector3f d =
          T_camera_map.linear() * (cell_size * cell_at(Eigen::Vector3i::Zero(), i).cast<float>());
      for (std::size_t axis = 0; axis < 3; ++axis)
        offset[axis][static_cast<std::size_t>(i)] = d[static_cast<int>(axis)];
    }
  }
};

void DepthCarver::carve(const cv::Mat& depth, const CameraModel& camera,
                        const Eigen::Isometry3d& T_map_camera, OccupancyGrid& grid) {
  const Seeing seeing = hits_of(depth, camera, T_map_camera, grid);
  miss(seeing, grid);
  hits_.hit(grid);
}

void DepthCarver::see(const cv::Mat& depth, const CameraModel& camera, const Eigen::Isometry3d& T_map_camera,
                      const OccupancyGrid& grid) {
  hits_of(depth, camera, T_map_camera, grid);
}

DepthCarver::Seeing DepthCarver::hits_of(const cv::Mat& depth, const CameraModel& camera,
                                         const Eigen::Isometry3d& T_map_camera, const OccupancyGrid& grid) {
  const double reach = T_map_camera.translation().cwiseAbs().maxCoeff() / grid.settings().cell_size;
  if (!T_map_camera.matrix().allFinite() || !(reach < (1 << 18)))
    throw std::invalid_argument("T_map_camera: must be finite and within 2^18 cells of the map's origin");
  view_.set(depth, camera);
  const Seeing seeing(grid, T_map_camera);
  collect_hits(seeing);
  return seeing;
}

// Two pixels a cell at least, at the farthest: more would hit the same cells again.
void DepthCarver::collect_hits(const Seeing& seeing) {
  const CameraModel& camera = view_.camera();
  const auto max_range = static_cast<float>(seeing.settings.max_range);
  const float inverse_size = 1 / seeing.cell_size;
  const int stride =
      std::max(1, static_cast<int>(0.5 * seeing.settings.cell_size * camera.fx / seeing.settings.max_range));
  const auto fx = static_cast<float>(1 / camera.fx), fy = static_cast<float>(1 / camera.fy);
  const auto cx = static_cast<float>(camera.cx), cy = static_cast<float>(camera.cy);
  hits_.clear();
  for (int v = 0; v < camera.height; v += stride) {
    const auto* row = view_.depth().ptr<float>(v);
    for (int u = 0; u < camera.width; u += stride) {
      const float z = row[u];
      if (!(z > nearest_cell && z <= max_range)) continue;
      const Eigen::Vector3f ray((static_cast<float>(u) - cx) * fx, (static_cast<float>(v) - cy) * fy, 1);
      const Eigen::Vector3f p = (seeing.T_map_camera * (z * ray)) * inverse_size;
      hits_.add({floor_of(p.x()), floor_of(p.y()), floor_of(p.z())});
    }
  }
}

// The whole block at once where its corners tell enough.
DepthCarver::Sight DepthCarver::look(const Seeing& seeing, const Eigen::Vector3i& block,
                                     Flags& through) const {
  const CameraModel& camera = view_.camera();
  const float cell = seeing.cell_size, side = block_side * cell;
  const auto max_range = static_cast<float>(seeing.settings.max_range);
  const Eigen::Vector3f corner = seeing.T_camera_map * (side * block.cast<float>());
  const Eigen::Matrix3f edges = side * seeing.T_camera_map.linear();
  Eigen::Vector2f low = Eigen::Vector2f::Constant(1e9f), high = -low;
  float nearest = 1e9f, farthest = -1e9f;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3f p =
        corner + edges * Eigen::Vector3f(static_cast<float>(i & 1), static_cast<float>(i >> 1 & 1),
                                         static_cast<float>(i >> 2));
    nearest = std::min(nearest, p.z());
    farthest = std::max(farthest, p.z());
    const float inverse = 1 / std::max(p.z(), nearest_cell);
    const Eigen::Vector2f pixel(
        p.x() * static_cast<float>(camera.fx) * inverse + static_cast<float>(camera.cx),
        p.y() * static_cast<float>(camera.fy) * inverse + static_cast<float>(camera.cy));
    low = low.cwiseMin(pixel);
    high = high.cwiseMax(pixel);
  }
  if (farthest < nearest_cell || nearest > max_range) return Sight::hidden;
  const Eigen::Vector2f end(static_cast<float>(camera.width - 1), static_cast<float>(camera.height - 1));
  const bool in_front = nearest > nearest_cell;
  if (in_front && ((high.array() < 0).any() || (low.array() > end.array()).any())) return Sight::hidden;
  const bool inside = in_front && (low.array() >= 0).all() && (high.array() <= end.array()).all();
  if (!in_front) low = Eigen::Vector2f::Zero(), high = end;
  const Eigen::Vector2i first = low.cwiseMax(0).cast<int>(), last = high.cwiseMin(end).cast<int>();
  const CarvingView::Extremes seen = view_.extremes(first, last);
  if (seen.most < nearest) return Sight::hidden;

  ProjectedBlock projected{};
  projected.margin = 0.5f * cell;
  projected.slack = static_cast<float>(seeing.settings.depth_slack);
  if (inside && farthest < max_range &&
      seen.least > farthest + projected.margin + projected.slack * farthest * farthest)
    return Sight::through;
  const Eigen::Vector3f first_cell =
      seeing.T_camera_map * ((block_side * block.cast<float>().array() + 0.5f) * cell).matrix();
  projected.x = first_cell.x(), projected.y = first_cell.y(), projected.z = first_cell.z();
  projected.dx = seeing.offset[0].data(), projected.dy = seeing.offset[1].data(),
  projected.dz = seeing.offset[2].data();
  projected.max_range = max_range;
  const float middle = std::max(nearest_cell, 0.5f * (nearest + farthest));
  const cv::Mat& image =
      view_.nearest(CarvingView::level_for(0.25f * cell * static_cast<float>(camera.fx) / middle));
  const DepthPlane plane{image.ptr<float>(),
                         static_cast<int>(image.step1()),
                         static_cast<float>(camera.width),
                         static_cast<float>(camera.height),
                         static_cast<float>(camera.fx),
                         static_cast<float>(camera.fy),
                         static_cast<float>(camera.cx),
                         static_cast<float>(camera.cy)};
  see_through(projected, plane, through.data());
  return Sight::mixed;
}

// All blocks of the box around what the image sees.
void DepthCarver::miss(const Seeing& seeing, OccupancyGrid& grid) const {
  const CameraModel& camera = view_.camera();
  const float depth = std::min(view_.farthest(), static_cast<float>(seeing.settings.max_range));
  Eigen::AlignedBox3f box(seeing.T_map_camera.translation());
  for (const int u : {0, camera.width})
    for (const int v : {0, camera.height})
      box.extend(seeing.T_map_camera * (depth * camera.ray({u - 0.5, v - 0.5}).cast<float>()));
  const Eigen::Vector3i first = block_of(grid.cell_of(box.min())), last = block_of(grid.cell_of(box.max()));

  const LogOdds step = log_odds(seeing.settings.miss), least = log_odds(seeing.settings.most_free);
  const Flags none{};
  Flags through{};
  BlockLogOdds cells;
  for (int z = first.z(); z <= last.z(); ++z)
    for (int y = first.y(); y <= last.y(); ++y)
      for (int x = first.x(); x <= last.x(); ++x) {
        const Eigen::Vector3i block(x, y, z);
        const Sight sight = look(seeing, block, through);
        if (sight == Sight::hidden) continue;
        const Flags* hit = hits_.find(block);
        if (sight == Sight::through && hit == nullptr) {
          const auto same = grid.uniform(block);
          if (same) {
            const int before = *same == unknown_log_odds ? 0 : *same;
            grid.store_uniform(block, static_cast<LogOdds>(std::max<int>(before + step, least)));
            continue;
          }
        }
        if (sight == Sight::through)
          through.fill(1);
        else if (std::find(through.begin(), through.end(), 1) == through.end())
          continue;
        grid.load(block, cells);
        count_misses(cells.data(), through.data(), hit != nullptr ? hit->data() : none.data(), step, least);
        grid.store(block, cells);
      }
}

}  // namespace lcmslam
