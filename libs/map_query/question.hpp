#pragma once
// What can be asked of a map, as JSON says it: {"ask": "distance", "points": [[1, 2, 0.5]]}. docs/QUERIES.md
// lists all.
//
// Lengths are in m, angles in rad, places in the map's frame. parse_question() throws std::invalid_argument
// that names the member, its value and what would be right.

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <lcmslam/map_query/collision.hpp>
#include <lcmslam/map_query/frontiers.hpp>

namespace lcmslam {

using Points = std::vector<Eigen::Vector3d>;

/// A part of the map: a box along the axes, or a sphere; all of it where nothing is said.
struct Region {
  Eigen::Vector3d from = Eigen::Vector3d::Constant(-1e6), to = Eigen::Vector3d::Constant(1e6);  ///< corners
  std::optional<Sphere> sphere;

  bool contains(const Eigen::Vector3d& point) const {
    if (sphere) return (point - sphere->centre).norm() <= sphere->radius;
    return (point.array() >= from.array()).all() && (point.array() <= to.array()).all();
  }
  /// Whether anything within `radius` of the point may be inside.
  bool reaches(const Eigen::Vector3d& point, double radius) const {
    if (sphere) return (point - sphere->centre).norm() <= sphere->radius + radius;
    return (point.array() >= from.array() - radius).all() && (point.array() <= to.array() + radius).all();
  }
};

/// Distance to the nearest obstacle and its gradient, at each point.
struct DistanceQuestion {
  Points points;
};

/// Whether each body touches what is kept or what the newest frame shows.
struct CollisionQuestion {
  using Body = std::variant<Sphere, Capsule, Box>;
  std::vector<Body> bodies;
};

/// The first pose at which a robot collides on its way.
struct PathQuestion {
  Box robot;  ///< T_map_box: of its middle in the robot's frame
  std::vector<Eigen::Isometry3d> T_map_robot;
};

/// Free, occupied or unknown, at each point.
struct SpaceQuestion {
  Points points;
};

/// The dense map's coloured points, averaged in cells of `resolution`.
struct CloudQuestion {
  Region region;
  double resolution = 0.02;  ///< m
};

enum class MeshFormat { ply, glb };

/// The dense surface.
struct MeshQuestion {
  Region region;
  MeshFormat format = MeshFormat::ply;
};

/// Planes with a point of their outline's box within `radius` of `near`.
struct PlanesQuestion {
  std::optional<Eigen::Vector3d> near;  ///< nothing: all
  double radius = 1;                    ///< m
  bool supporting = false;              ///< only floors and table tops
};

/// What stands on the supporting planes there.
struct ObjectsQuestion {
  PlanesQuestion planes;
};

struct LandmarksQuestion {
  Region region;
};

/// Where free space meets unknown space.
struct FrontiersQuestion {
  FrontierSettings settings;
};

/// The grid for navigation around where the robot is.
struct GridQuestion {};

/// Where the camera is, by the features that it saw at `utime` (0: the newest that were heard).
struct LocaliseQuestion {
  Utime utime = 0;
};

struct Question {
  using What = std::variant<DistanceQuestion, CollisionQuestion, PathQuestion, SpaceQuestion, CloudQuestion,
                            MeshQuestion, PlanesQuestion, ObjectsQuestion, LandmarksQuestion,
                            FrontiersQuestion, GridQuestion, LocaliseQuestion>;
  What what;
  double deadline = 5;  ///< s after which nobody waits for the answer any more
};

/// Of a question at most.
constexpr std::size_t most_asked_points = 20'000;

Question parse_question(const std::string& json);
/// As parse_question() reads it.
std::string to_json(const Question& question);

/// Places of the bodies in the order that JSON has them in, question and answer: by kind.
std::vector<std::size_t> json_order(const std::vector<CollisionQuestion::Body>& bodies);

}  // namespace lcmslam
