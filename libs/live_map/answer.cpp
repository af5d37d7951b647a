#include <lcmslam/live_map/answer.hpp>

#include <nlohmann/json.hpp>
#include <numeric>
#include <stdexcept>

#include <lcmslam/cloud/voxel_average.hpp>
#include <lcmslam/map_layers/export_navigation_grid.hpp>
#include <lcmslam/map_store/map_export.hpp>
#include <lcmslam/planes/objects.hpp>
#include <lcmslam/surface/mesh_export.hpp>

namespace lcmslam {
namespace {

using nlohmann::json;

/// To hundredths of a millimetre: what lies below is noise, and digits are bytes on the bus.
double rounded(double value) {
  return std::round(1e5 * value) / 1e5;
}
json row(const Eigen::Vector3d& v) {
  return {rounded(v.x()), rounded(v.y()), rounded(v.z())};
}
Answer as_json(const json& value) {
  return {"application/json", value.dump()};
}

const LiveMap& live(const AskedMap& map) {
  if (!map.live) throw std::runtime_error("no frame has a place in the map yet");
  return *map.live;
}

/// As sphere, capsule or box is, or a point: all within `reach` of it.
Eigen::AlignedBox3d box_around(const Eigen::Vector3d& point, double reach = 0) {
  const Eigen::Vector3d sides = Eigen::Vector3d::Constant(reach);
  return {Eigen::Vector3d(point - sides), Eigen::Vector3d(point + sides)};
}
Eigen::AlignedBox3d box_around(const Sphere& sphere) {
  return box_around(sphere.centre, sphere.radius);
}
Eigen::AlignedBox3d box_around(const Capsule& capsule) {
  return box_around(capsule.from, capsule.radius).merged(box_around(capsule.to, capsule.radius));
}
Eigen::AlignedBox3d box_around(const Box& box) {
  return box_around(box.T_map_box.translation(), box.half_size.norm());
}
Eigen::AlignedBox3d box_around(const CollisionQuestion::Body& body) {
  return std::visit([](const auto& b) { return box_around(b); }, body);
}

using Fields = std::vector<const DistanceField*>;  // of the map, and of the newest frame where it reaches

/// Calls `ask(number, item, fields)` with each item; what comes after one for which it says false may be left
/// out. Where the robot is near it looks once. Elsewhere distances are made for some metres around an item,
/// and for all others there. Throws std::runtime_error when that takes longer than who asks waits.
template <class Item, class Ask>
void ask_of_space(const AskedMap& map, const std::vector<Item>& items, const Ask& ask) {
  constexpr double around = 3;  // m
  const LiveSpace& space = live(map).space();
  std::size_t wanted = items.size(), answered = 0;
  const auto expect_in_time = [&] {
    if (map.is_late && map.is_late())
      throw std::runtime_error("its deadline was over when " + std::to_string(wanted - answered) +
                               " of its " + std::to_string(items.size()) +
                               " places had no answer yet; ask for fewer, for places nearer to the robot or "
                               "to one another, or with a later deadline");
  };
  const auto ask_where = [&](const std::vector<std::size_t>& numbers, const auto& covers,
                             const Fields& fields) {
    std::vector<std::size_t> left;
    for (const std::size_t i : numbers) {
      if (i >= wanted) break;
      if (!covers(box_around(items[i]))) {
        left.push_back(i);
        continue;
      }
      expect_in_time();
      if (!ask(i, items[i], fields)) wanted = i;
      ++answered;
    }
    return left;
  };
  std::vector<std::size_t> open(items.size());  // numbers of items, in their order
  std::iota(open.begin(), open.end(), std::size_t{0});
  open = space.ask([&](const LiveSpace::View& view) {
    return ask_where(open, [&](const Eigen::AlignedBox3d& box) { return view.distances.covers(box); },
                     {&view.distances.field(), &view.newest});
  });
  while (!open.empty() && open.front() < wanted) {
    expect_in_time();
    Eigen::AlignedBox3d made_for = box_around(items[open.front()]);
    const Eigen::Vector3d reach = Eigen::Vector3d::Constant(around);
    made_for = {Eigen::Vector3d(made_for.min() - reach), Eigen::Vector3d(made_for.max() + reach)};
    const DistanceField made = space.distances_in(made_for);
    open = space.ask([&](const LiveSpace::View& view) {  // what the newest frame shows is far sometimes, too
      return ask_where(open, [&](const Eigen::AlignedBox3d& box) { return made_for.contains(box); },
                       {&made, &view.newest});
    });
  }
}

Answer reply(const DistanceQuestion& q, const AskedMap& map) {
  std::vector<DistanceField::Sample> samples(q.points.size());
  ask_of_space(map, q.points, [&](std::size_t i, const Eigen::Vector3d& point, const Fields& fields) {
    samples[i] = fields.front()->sample(point);
    for (const DistanceField* field : fields)
      if (const auto other = field->sample(point);
          other.distance < samples[i].distance && other.distance < field->truncation())
        samples[i] = other;
    return true;
  });
  json distances = json::array(), gradients = json::array();
  for (const DistanceField::Sample& sample : samples) {
    distances.push_back(rounded(sample.distance));
    gradients.push_back(row(sample.gradient));
  }
  return as_json({{"distances", distances},
                  {"gradients", gradients},
                  {"truncation", live(map).settings().distance.truncation}});
}

Answer reply(const CollisionQuestion& q, const AskedMap& map) {
  std::vector<bool> collides(q.bodies.size());
  ask_of_space(map, q.bodies, [&](std::size_t i, const CollisionQuestion::Body& body, const Fields& fields) {
    const CollisionChecker checker(fields);
    collides[i] = std::visit([&](const auto& b) { return checker.collides(b); }, body);
    return true;
  });
  return as_json({{"collides", collides}});
}

Answer reply(const PathQuestion& q, const AskedMap& map) {
  std::vector<Box> places;
  for (const Eigen::Isometry3d& T : q.T_map_robot)
    places.push_back({T * q.robot.T_map_box, q.robot.half_size});
  std::optional<std::size_t> first;
  ask_of_space(map, places, [&](std::size_t i, const Box& place, const Fields& fields) {
    const bool collides = CollisionChecker(fields).collides(place);
    if (collides) first = i;  // earlier than any before: later ones are not asked about
    return !collides;
  });
  json answer = {{"free", !first.has_value()}};
  if (first) answer["first_collision"] = *first;
  return as_json(answer);
}

Answer reply(const SpaceQuestion& q, const AskedMap& map) {
  json states = json::array();
  live(map).space().ask_occupied([&](const OccupancyGrid& occupied) {
    for (const Eigen::Vector3d& point : q.points) {
      const CellState state = occupied.state(Eigen::Vector3f(point.cast<float>()));
      states.push_back(state == CellState::free       ? "free"
                       : state == CellState::occupied ? "occupied"
                                                      : "unknown");
    }
  });
  return as_json({{"states", states}});
}

Answer reply(const CloudQuestion& q, const AskedMap& map) {
  VoxelAverage average(q.resolution);
  average.add(map.cloud);
  return {"model/ply", cloud_ply(average.result())};
}

/// The triangles with a corner inside, and their vertices.
Mesh cut(const Mesh& mesh, const Region& region) {
  constexpr auto left_out = std::numeric_limits<std::uint32_t>::max();
  Mesh part;
  std::vector<bool> inside;
  inside.reserve(mesh.vertices.size());
  for (const Eigen::Vector3f& v : mesh.vertices) inside.push_back(region.contains(v.cast<double>()));
  std::vector<std::uint32_t> place(mesh.vertices.size(), left_out);
  for (const auto& triangle : mesh.triangles) {
    if (!inside[triangle[0]] && !inside[triangle[1]] && !inside[triangle[2]]) continue;
    std::array<std::uint32_t, 3> corners{};
    for (std::size_t i = 0; i < 3; ++i) {
      std::uint32_t& at = place[triangle[i]];
      if (at == left_out) {
        at = static_cast<std::uint32_t>(part.vertices.size());
        part.vertices.push_back(mesh.vertices[triangle[i]]);
        part.normals.push_back(mesh.normals[triangle[i]]);
        part.colours.push_back(mesh.colours[triangle[i]]);
      }
      corners[i] = at;
    }
    part.triangles.push_back(corners);
  }
  return part;
}

Answer reply(const MeshQuestion& q, const AskedMap& map) {
  const Mesh part = cut(live(map).mesh(), q.region);
  if (q.format == MeshFormat::glb) return {"model/gltf-binary", mesh_glb(part)};
  return {"model/ply", mesh_ply(part)};
}

const char* name_of(PlaneLabel label) {
  switch (label) {
    case PlaneLabel::floor:
      return "floor";
    case PlaneLabel::table_top:
      return "table_top";
    case PlaneLabel::ceiling:
      return "ceiling";
    case PlaneLabel::wall:
      return "wall";
    case PlaneLabel::other:
      break;
  }
  return "other";
}

Eigen::AlignedBox3d box_of(const PlanePatch& patch) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& corner : patch.outline) box.extend(corner);
  return box;
}

std::vector<PlanePatch> asked(const PlanesQuestion& q, const LiveMap& map) {
  std::vector<PlanePatch> patches = map.planes();
  patches.erase(std::remove_if(patches.begin(), patches.end(),
                               [&](const PlanePatch& patch) {
                                 const bool supports =
                                     patch.label == PlaneLabel::floor || patch.label == PlaneLabel::table_top;
                                 if (q.supporting && !supports) return true;
                                 return q.near && box_of(patch).exteriorDistance(*q.near) > q.radius;
                               }),
                patches.end());
  return patches;
}

json told(const PlanePatch& patch) {
  json outline = json::array();
  for (const Eigen::Vector3d& corner : patch.outline) outline.push_back(row(corner));
  const PlaneFit& fit = patch.fit;
  return {{"label", name_of(patch.label)},
          {"normal", row(fit.plane.normal)},
          {"offset", rounded(fit.plane.offset)},
          {"centre", row(fit.centre)},
          {"axis", row(fit.axis)},
          // Of the tilts about axis and normal x axis (rad^2) and of the distance at the centre (m^2).
          {"variance", {fit.variance.x(), fit.variance.y(), fit.variance.z()}},
          {"rms", rounded(fit.rms)},
          {"area", rounded(patch.area)},
          {"looks", patch.looks},
          {"outline", outline}};
}

Answer reply(const PlanesQuestion& q, const AskedMap& map) {
  json planes = json::array();
  for (const PlanePatch& patch : asked(q, live(map))) planes.push_back(told(patch));
  return as_json({{"planes", planes}});
}

Answer reply(const ObjectsQuestion& q, const AskedMap& map) {
  json objects = json::array();
  const std::vector<Eigen::Vector3f> points = live(map).mesh().vertices;
  for (const PlanePatch& patch : asked(q.planes, live(map)))
    for (const StandingObject& object : find_objects(points, patch, live(map).settings().objects)) {
      const Eigen::Quaterniond turn(object.T_map_box.linear());
      objects.push_back(
          {{"centre", row(object.T_map_box.translation())},
           {"quaternion", {rounded(turn.w()), rounded(turn.x()), rounded(turn.y()), rounded(turn.z())}},
           {"size", row(object.size)},
           {"points", object.points},
           {"on", name_of(patch.label)},
           {"height", rounded(patch.fit.centre.z())}});
    }
  return as_json({{"objects", objects}});
}

Answer reply(const LandmarksQuestion&, const AskedMap& map) {
  json landmarks = json::array();
  for (const Landmark& l : map.landmarks) {
    json covariance = json::array();
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j) covariance.push_back(l.covariance(i, j));
    landmarks.push_back(
        {{"id", l.id}, {"mean", row(l.mean)}, {"covariance", covariance}, {"observations", l.observations}});
  }
  return as_json({{"landmarks", landmarks}});
}

Answer reply(const FrontiersQuestion& q, const AskedMap& map) {
  json frontiers = json::array();
  for (const Frontier& f : find_frontiers(live(map).space().copy(), q.settings))
    frontiers.push_back({{"centroid", row(f.centroid)}, {"cell", row(f.cell)}, {"cells", f.cells}});
  return as_json({{"frontiers", frontiers}});
}

Answer reply(const GridQuestion&, const AskedMap& map) {
  if (!map.T_map_robot)
    throw std::runtime_error("where the robot is, around which the grid lies, is not known yet");
  const OccupancyGrid space = live(map).space().copy();
  const NavigationGrid grid = make_navigation_grid(space, live(map).settings().navigation, *map.T_map_robot);
  json rows = json::array();
  for (int y = 0; y < grid.cells.rows; ++y) {
    std::string line;
    for (int x = 0; x < grid.cells.cols; ++x) {
      const std::int8_t cell = grid.cells(y, x);
      line += cell == NavigationGrid::free ? '.' : cell == NavigationGrid::occupied ? '#' : '?';
    }
    rows.push_back(line);
  }
  return as_json({{"cell_size", grid.cell_size},
                  {"origin", {rounded(grid.origin.x()), rounded(grid.origin.y())}},
                  {"rows", rows}});
}

json pose_of(const Eigen::Isometry3d& T) {
  const Eigen::Quaterniond turn(T.linear());
  return {{"position", row(T.translation())}, {"quaternion", {turn.w(), turn.x(), turn.y(), turn.z()}}};
}

Answer reply(const LocaliseQuestion&, const AskedMap& map) {
  if (!map.locate) throw std::runtime_error("the map server keeps no places");
  const auto [located, frame, T_robot_camera] = map.locate();
  const PlaceEvidence& e = located.evidence;
  json reply = {{"found", located.place.has_value()},
                {"evidence",
                 {{"features", e.inliers},
                  {"features_of_another_place", e.other_inliers},
                  {"keyframes", e.keyframes.size()},
                  {"overlap", rounded(e.overlap)},
                  {"rms", rounded(e.rms)},
                  {"seen_through", rounded(e.seen_through)}}}};
  if (!located.place) {
    reply["why_not"] = located.why_not;
    return as_json(reply);
  }
  reply["frame"] = frame;
  reply["camera"] = pose_of(located.place->T_map_camera);
  if (T_robot_camera) reply["robot"] = pose_of(located.place->T_map_camera * T_robot_camera->inverse());
  json covariance = json::array();
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j) covariance.push_back(located.place->covariance(i, j));
  reply["covariance"] = covariance;
  return as_json(reply);
}

}  // namespace

Answer answer(const Question& question, const AskedMap& map) {
  return std::visit([&](const auto& what) { return reply(what, map); }, question.what);
}

}  // namespace lcmslam
