#pragma once
// Questions to a running map server from another program:
//
//   lcmslam::MapClient map;
//   const auto hit = map.first_collision(robot, path);
//   if (hit) ...  // the path's pose at which the robot would collide
//
// Each call waits for its answer; one object serves one thread. Lengths are in m, places in the map's frame
// (Reply::frame). Calls throw MapError, with the server's words or because none came in time.

#include <chrono>
#include <memory>
#include <stdexcept>

#include <lcmslam/map_query/question.hpp>

namespace lcmslam {

class MapError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class MapClient {
 public:
  /// `lcm_url` as for the graph's processes; empty: LCM_DEFAULT_URL, or lcmslam's default. `deadline`: s that
  /// an answer may take until it begins to come. Throws MapError when the bus cannot be used.
  explicit MapClient(const std::string& lcm_url = "", double deadline = 5);
  ~MapClient();
  MapClient(const MapClient&) = delete;
  MapClient& operator=(const MapClient&) = delete;

  /// An answer as it came.
  struct Reply {
    std::string content;           ///< "application/json", "model/ply", "model/gltf-binary"
    std::string frame;             ///< that its places are in
    std::int64_t map_version = 0;  ///< counts every change of the map
    std::string bytes;
  };
  Reply ask(const Question& question);

  struct Distance {
    double distance;           ///< to the nearest obstacle; at most the server's truncation (2 m)
    Eigen::Vector3d gradient;  ///< of the distance; zero where nothing is near
  };
  std::vector<Distance> distances(const Points& points);

  /// Whether each of the bodies touches something, in their order. The newest frame counts at once.
  std::vector<bool> collides(const std::vector<CollisionQuestion::Body>& bodies);
  /// The first pose at which the robot collides; nothing: the way is free. The newest frame counts at once.
  std::optional<std::size_t> first_collision(const Box& robot,
                                             const std::vector<Eigen::Isometry3d>& T_map_robot);

  enum class Space { unknown, free, occupied };
  std::vector<Space> space(const Points& points);

  struct Object {
    Eigen::Isometry3d T_map_box;  ///< of its middle; z is up from what it stands on
    Eigen::Vector3d size;
  };
  /// What stands within `radius` of the point, on floors and tables.
  std::vector<Object> objects(const Eigen::Vector3d& near, double radius);

 private:
  class Bus;
  double deadline_;
  std::unique_ptr<Bus> bus_;
};

}  // namespace lcmslam
