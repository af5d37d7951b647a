#include <lcmslam/map_layers/navigation_grid.hpp>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <stdexcept>

#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

class GroundFollower {
 public:
  GroundFollower(const OccupancyGrid& grid, const NavigationSettings& settings, const Eigen::Vector3d& robot)
      : grid_(grid),
        settings_(settings),
        step_(std::max(1, cells(settings.max_step))),
        height_(cells(settings.robot_height)),
        reach_(cells(settings.reach)),
        start_(ground_under(robot)) {
    const int side = 2 * reach_ + 1;
    result_.cell_size = size();
    result_.origin = (start_.head<2>().array() - reach_).cast<double>() * size();
    result_.cells.create(side, side);
    result_.cells.setTo(NavigationGrid::unknown);
    result_.ground.create(side, side);
    result_.ground.setTo(std::numeric_limits<float>::quiet_NaN());
    level_.create(side, side);
    level_.setTo(not_reached);
  }

  void follow_from(const Eigen::Vector3d& robot) {
    stand(ground_under(robot) - start_);
    while (!known_.empty() || !guessed_.empty()) {
      std::deque<Column>& next = known_.empty() ? guessed_ : known_;  // what is known first
      const Column column = next.front();
      next.pop_front();
      for (const cv::Point side : {cv::Point(1, 0), cv::Point(-1, 0), cv::Point(0, 1), cv::Point(0, -1)})
        visit({column.at + side, column.level, column.gap});
    }
  }

  NavigationGrid result() {
    refuse_slopes();
    return std::move(result_);
  }

 private:
  static constexpr int not_reached = std::numeric_limits<int>::min();
  struct Column {
    cv::Point at;
    int level;  // z of the ground's highest cell
    int gap;    // columns since the ground was known
  };

  double size() const { return grid_.settings().cell_size; }
  int cells(double length) const { return static_cast<int>(std::lround(length / size())); }
  CellState state(const cv::Point& at, int z) const {
    return grid_.state(Eigen::Vector3i(start_.x() + at.x - reach_, start_.y() + at.y - reach_, z));
  }

  // The cell whose top the robot stands on.
  Eigen::Vector3i ground_under(const Eigen::Vector3d& robot) const {
    Eigen::Vector3i cell = grid_.cell_of(robot.cast<float>());
    cell.z() = static_cast<int>(std::lround(robot.z() / size())) - 1;
    return cell;
  }

  // Where the robot stands there is ground, though no camera sees it; what is seen there counts more.
  // `place`: from the start, cells.
  void stand(const Eigen::Vector3i& place) {
    const int level = start_.z() + place.z();
    const int radius = cells(settings_.robot_radius);
    for (int y = -radius; y <= radius; ++y)
      for (int x = -radius; x <= radius; ++x) {
        const cv::Point at(reach_ + place.x() + x, reach_ + place.y() + y);
        if (x * x + y * y > radius * radius || !is_inside(at)) continue;
        visit({at, level, 0});
        if (result_.cells(at) == NavigationGrid::unknown) settle(at, level);
      }
  }

  bool is_inside(const cv::Point& at) const {
    return at.x >= 0 && at.y >= 0 && at.x < level_.cols && at.y < level_.rows;
  }

  void settle(const cv::Point& at, int level) {
    result_.cells(at) = NavigationGrid::free;
    result_.ground(at) = static_cast<float>((level + 1) * size());
    level_(at) = level;
    known_.push_back({at, level, 0});
  }

  // A column beside one whose ground is known or guessed.
  void visit(const Column& column) {
    const cv::Point at = column.at;
    if (!is_inside(at) || level_(at) != not_reached) return;
    level_(at) = column.level;
    int ground = column.level + step_;
    while (ground >= column.level - step_ && state(at, ground) != CellState::occupied) --ground;
    const bool found = ground >= column.level - step_;
    bool in_the_way = !found && state(at, column.level - step_) == CellState::free;  // seen to go down
    const int floor = found ? ground : column.level;
    for (int z = floor + 1; z <= floor + height_ && !in_the_way; ++z)
      in_the_way = state(at, z) == CellState::occupied;
    if (found && !in_the_way) return settle(at, ground);
    if (in_the_way) result_.cells(at) = NavigationGrid::occupied;
    // Also through what is in the way: so the inside of things is occupied too.
    if (column.gap < cells(settings_.max_gap)) guessed_.push_back({at, column.level, column.gap + 1});
  }

  // Ground that rises by more over slope_length than a slope and a step explain.
  void refuse_slopes() {
    const int length = std::max(1, cells(settings_.slope_length));
    const double most = std::tan(settings_.max_slope) * length * size() + (step_ + 0.5) * size();
    const cv::Mat_<std::int8_t> before = result_.cells.clone();
    for (const cv::Point side : {cv::Point(1, 0), cv::Point(0, 1)})
      for (int y = 0; y + length * side.y < before.rows; ++y)
        for (int x = 0; x + length * side.x < before.cols; ++x) {
          const cv::Point from(x, y), to = from + length * side;
          if (before(from) != NavigationGrid::free || before(to) != NavigationGrid::free) continue;
          if (std::abs(result_.ground(from) - result_.ground(to)) <= most) continue;
          for (int i = 0; i <= length; ++i)
            if (before(from + i * side) == NavigationGrid::free)
              result_.cells(from + i * side) = NavigationGrid::occupied;
        }
  }

  const OccupancyGrid& grid_;
  const NavigationSettings& settings_;
  int step_, height_, reach_;  // cells
  Eigen::Vector3i start_;      // cell
  NavigationGrid result_;
  cv::Mat_<int> level_;
  std::deque<Column> known_, guessed_;
};

}  // namespace

std::int8_t NavigationGrid::at(double x, double y) const {
  const double column = std::floor((x - origin.x()) / cell_size),
               row = std::floor((y - origin.y()) / cell_size);
  if (!(column >= 0 && row >= 0 && column < cells.cols && row < cells.rows)) return unknown;
  return cells(static_cast<int>(row), static_cast<int>(column));
}

NavigationGrid make_navigation_grid(const OccupancyGrid& grid, const NavigationSettings& settings,
                                    const Eigen::Isometry3d& T_map_robot,
                                    const std::vector<Eigen::Vector3d>& also_stood) {
  check(settings, "navigation");
  const auto exists = [&](const Eigen::Vector3d& place) {
    return voxel_exists(place.cast<float>(), 1 / grid.cell_size());
  };
  if (!exists(T_map_robot.translation()))
    throw std::invalid_argument("T_map_robot: must be finite and within 10^6 cells of the map's origin");
  GroundFollower follower(grid, settings, T_map_robot.translation());
  follower.follow_from(T_map_robot.translation());
  for (const Eigen::Vector3d& place : also_stood)
    if (exists(place)) follower.follow_from(place);
  return follower.result();
}

NavigationSettings reaching_all(const OccupancyGrid& grid, NavigationSettings settings,
                                const Eigen::Isometry3d& T_map_robot) {
  constexpr double most_cells = 2500;  // to each side: a quarter of a gigabyte while it is made
  const double cell = grid.settings().cell_size, block = block_side * cell;
  const Eigen::Vector2d robot = T_map_robot.translation().head<2>();
  double farthest = 0;
  for (const Eigen::Vector3i& at : grid.blocks()) {
    const Eigen::Vector2d middle = (at.head<2>().cast<double>().array() + 0.5) * block;
    farthest = std::max(farthest, (middle - robot).cwiseAbs().maxCoeff() + 0.5 * block);
  }
  settings.reach = std::max(settings.reach, std::min({farthest, most_cells * cell, 100.0}));
  return settings;
}

}  // namespace lcmslam
