#include <lcmslam/map_query/question.hpp>

#include <algorithm>
#include <numeric>

#include <lcmslam/map_query/json_fields.hpp>

namespace lcmslam {
namespace {

using nlohmann::json;

// One place says what each question is called and how its members are read and written.

Eigen::Vector3d vector(const std::array<double, 3>& v) {
  return {v[0], v[1], v[2]};
}
json row(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

Points points(JsonFields& fields) {
  Points points;
  for (const auto& p : fields.rows<3>("points", most_asked_points)) points.push_back(vector(p));
  return points;
}
json rows(const Points& points) {
  json list = json::array();
  for (const Eigen::Vector3d& p : points) list.push_back(row(p));
  return list;
}

double positive(const std::string& key, double value) {
  if (!(value > 0))
    throw std::invalid_argument("'" + key + "' has the size " + std::to_string(value) + ", must be above 0");
  return value;
}

Region region(JsonFields& fields) {
  Region region;
  if (fields.find("centre") != nullptr)
    region.sphere = Sphere{vector(fields.numbers<3>("centre")), fields.number("radius", 1, {1e-3, 1e6})};
  if (fields.find("from") != nullptr || fields.find("to") != nullptr) {
    region.from = vector(fields.numbers<3>("from"));
    region.to = vector(fields.numbers<3>("to"));
    if ((region.from.array() > region.to.array()).any())
      throw std::invalid_argument("'from' must not be above 'to' along any axis");
    if (region.sphere) throw std::invalid_argument("a region has 'centre' and 'radius' or 'from' and 'to'");
  }
  return region;
}
json region_members(const Region& region) {
  json j = json::object();
  if (region.sphere) {
    j["centre"] = row(region.sphere->centre);
    j["radius"] = region.sphere->radius;
  } else if (region.from != Region().from || region.to != Region().to) {
    j["from"] = row(region.from);
    j["to"] = row(region.to);
  }
  return j;
}

constexpr double largest_body = 30;  // m: bodies are looked at part by part, within one look at the map

void check_size(const std::string& key, double length) {
  if (length > largest_body)
    throw std::invalid_argument("'" + key + "' holds a body of " + std::to_string(length) +
                                " m, must be at most " + std::to_string(largest_body) +
                                " m (all lengths are in m)");
}

Eigen::Quaterniond rotation(const std::string& key, const std::array<double, 4>& wxyz) {
  const Eigen::Quaterniond q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  if (std::abs(q.norm() - 1) > 1e-3)
    throw std::invalid_argument("'" + key + "' holds the quaternion (w, x, y, z) of norm " +
                                std::to_string(q.norm()) + ", must be 1");
  return q.normalized();
}

/// x y z, quaternion w x y z, and the box's whole sides.
Box box(const std::string& key, const std::array<double, 10>& v) {
  Box box;
  box.T_map_box = Eigen::Translation3d(v[0], v[1], v[2]) * rotation(key, {v[3], v[4], v[5], v[6]});
  box.half_size = 0.5 * Eigen::Vector3d(positive(key, v[7]), positive(key, v[8]), positive(key, v[9]));
  check_size(key, 2 * box.half_size.maxCoeff());
  return box;
}
json box_row(const Box& box) {
  const Eigen::Vector3d t = box.T_map_box.translation(), s = 2 * box.half_size;
  const Eigen::Quaterniond q(box.T_map_box.linear());
  return {t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z(), s.x(), s.y(), s.z()};
}

void read(JsonFields& f, DistanceQuestion& q) {
  q.points = points(f);
}
json members(const DistanceQuestion& q) {
  return {{"points", rows(q.points)}};
}

void read(JsonFields& f, SpaceQuestion& q) {
  q.points = points(f);
}
json members(const SpaceQuestion& q) {
  return {{"points", rows(q.points)}};
}

void read(JsonFields& f, CollisionQuestion& q) {
  if (f.find("spheres") != nullptr)
    for (const auto& v : f.rows<4>("spheres", most_asked_points)) {
      check_size("spheres", 2 * v[3]);
      q.bodies.emplace_back(Sphere{{v[0], v[1], v[2]}, positive("spheres", v[3])});
    }
  if (f.find("capsules") != nullptr)
    for (const auto& v : f.rows<7>("capsules", most_asked_points)) {
      const Eigen::Vector3d from(v[0], v[1], v[2]), to(v[3], v[4], v[5]);
      check_size("capsules", (to - from).norm() + 2 * v[6]);
      q.bodies.emplace_back(Capsule{from, to, positive("capsules", v[6])});
    }
  if (f.find("boxes") != nullptr)
    for (const auto& v : f.rows<10>("boxes", most_asked_points)) q.bodies.emplace_back(box("boxes", v));
  if (q.bodies.empty()) throw std::invalid_argument("'spheres', 'capsules' or 'boxes' is missing");
}
json members(const CollisionQuestion& q) {
  json j = json::object();
  for (const CollisionQuestion::Body& body : q.bodies) {
    if (const auto* s = std::get_if<Sphere>(&body))
      j["spheres"].push_back({s->centre.x(), s->centre.y(), s->centre.z(), s->radius});
    if (const auto* c = std::get_if<Capsule>(&body))
      j["capsules"].push_back(
          {c->from.x(), c->from.y(), c->from.z(), c->to.x(), c->to.y(), c->to.z(), c->radius});
    if (const auto* b = std::get_if<Box>(&body)) j["boxes"].push_back(box_row(*b));
  }
  return j;
}

void read(JsonFields& f, PathQuestion& q) {
  q.robot = box("robot", f.numbers<10>("robot"));
  if (f.find("tilted_poses") != nullptr) {
    for (const auto& p : f.rows<7>("tilted_poses", most_asked_points))
      q.T_map_robot.push_back(Eigen::Translation3d(p[0], p[1], p[2]) *
                              rotation("tilted_poses", {p[3], p[4], p[5], p[6]}));
    if (f.find("poses") != nullptr) throw std::invalid_argument("a path has 'poses' or 'tilted_poses'");
    return;
  }
  for (const auto& p : f.rows<4>("poses", most_asked_points))
    q.T_map_robot.push_back(Eigen::Translation3d(p[0], p[1], p[2]) *
                            Eigen::Isometry3d(Eigen::AngleAxisd(p[3], Eigen::Vector3d::UnitZ())));
}
json members(const PathQuestion& q) {
  const auto is_level = [](const Eigen::Isometry3d& T) { return T.linear()(2, 2) > 1 - 1e-12; };
  const bool level = std::all_of(q.T_map_robot.begin(), q.T_map_robot.end(), is_level);
  json poses = json::array();
  for (const Eigen::Isometry3d& T : q.T_map_robot) {
    json pose = row(T.translation());
    const Eigen::Quaterniond r(T.linear());
    if (level)
      pose.push_back(yaw(T));
    else
      pose.insert(pose.end(), {r.w(), r.x(), r.y(), r.z()});
    poses.push_back(pose);
  }
  return {{"robot", box_row(q.robot)}, {level ? "poses" : "tilted_poses", poses}};
}

void read(JsonFields& f, CloudQuestion& q) {
  q.region = region(f);
  q.resolution = f.number("resolution", q.resolution, {0.001, 10});
}
json members(const CloudQuestion& q) {
  json j = region_members(q.region);
  j["resolution"] = q.resolution;
  return j;
}

void read(JsonFields& f, MeshQuestion& q) {
  q.region = region(f);
  if (f.find("format") == nullptr) return;
  const std::string format = f.text("format");
  if (format != "ply" && format != "glb") throw std::invalid_argument("'format' must be \"ply\" or \"glb\"");
  q.format = format == "ply" ? MeshFormat::ply : MeshFormat::glb;
}
json members(const MeshQuestion& q) {
  json j = region_members(q.region);
  j["format"] = q.format == MeshFormat::ply ? "ply" : "glb";
  return j;
}

void read(JsonFields& f, PlanesQuestion& q) {
  if (f.find("near") != nullptr) q.near = vector(f.numbers<3>("near"));
  q.radius = f.number("radius", q.radius, {1e-3, 1e6});
  q.supporting = f.flag("supporting");
}
json members(const PlanesQuestion& q) {
  json j = {{"radius", q.radius}, {"supporting", q.supporting}};
  if (q.near) j["near"] = row(*q.near);
  return j;
}

void read(JsonFields& f, ObjectsQuestion& q) {
  if (f.find("near") != nullptr) q.planes.near = vector(f.numbers<3>("near"));
  q.planes.radius = f.number("radius", q.planes.radius, {1e-3, 1e6});
  q.planes.supporting = true;
}
json members(const ObjectsQuestion& q) {
  json j = {{"radius", q.planes.radius}};
  if (q.planes.near) j["near"] = row(*q.planes.near);
  return j;
}

void read(JsonFields& f, LandmarksQuestion& q) {
  q.region = region(f);
}
json members(const LandmarksQuestion& q) {
  return region_members(q.region);
}

void read(JsonFields& f, FrontiersQuestion& q) {
  q.settings.min_cells = static_cast<int>(f.number("min_cells", q.settings.min_cells, {1, 1e9}));
  q.settings.lowest = f.number("lowest", q.settings.lowest, {-1000, 1000});
  q.settings.highest = f.number("highest", q.settings.highest, {-1000, 1000});
  if (q.settings.lowest >= q.settings.highest)
    throw std::invalid_argument("'highest' must be above 'lowest'");
}
json members(const FrontiersQuestion& q) {
  return {
      {"min_cells", q.settings.min_cells}, {"lowest", q.settings.lowest}, {"highest", q.settings.highest}};
}

void read(JsonFields&, GridQuestion&) {}
json members(const GridQuestion&) {
  return json::object();
}

void read(JsonFields& f, LocaliseQuestion& q) {
  q.utime = static_cast<Utime>(f.number("utime", 0, {0, 9e15}));
}
json members(const LocaliseQuestion& q) {
  return {{"utime", q.utime}};
}

/// In the order of Question::What.
constexpr const char* names[] = {"distance", "collision", "path",      "space",     "cloud", "mesh",
                                 "planes",   "objects",   "landmarks", "frontiers", "grid",  "localise"};
static_assert(std::size(names) == std::variant_size_v<Question::What>);

template <std::size_t i = 0>
Question::What question_of(const std::string& name) {
  if constexpr (i == std::size(names)) {
    std::string known;
    for (const char* n : names) known += (known.empty() ? "" : ", ") + std::string(n);
    throw std::invalid_argument("'ask' is '" + name.substr(0, 40) + "', none of " + known);
  } else {
    if (name == names[i]) return std::variant_alternative_t<i, Question::What>();
    return question_of<i + 1>(name);
  }
}

constexpr int deepest = 8;  // lists and objects in one another; questions need three

// Whatever prints or copies such a value goes into itself as deep.
bool refuse_deep(int depth, json::parse_event_t /*event*/, const json& /*parsed*/) {
  if (depth > deepest)
    throw std::invalid_argument("a question nests lists deeper than " + std::to_string(deepest));
  return true;
}

}  // namespace

Question parse_question(const std::string& text) {
  json object;
  try {
    object = json::parse(text, refuse_deep);
  } catch (const json::exception& error) {
    throw std::invalid_argument(std::string("a question is JSON: ") + error.what());
  }
  JsonFields fields(object);
  Question question;
  question.what = question_of(fields.text("ask"));
  question.deadline = fields.number("deadline", question.deadline, {0.001, 3600});
  std::visit([&](auto& what) { read(fields, what); }, question.what);
  fields.done();
  return question;
}

std::string to_json(const Question& question) {
  json object = std::visit([](const auto& what) { return members(what); }, question.what);
  object["ask"] = names[question.what.index()];
  object["deadline"] = question.deadline;
  return object.dump();
}

std::vector<std::size_t> json_order(const std::vector<CollisionQuestion::Body>& bodies) {
  std::vector<std::size_t> order(bodies.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return bodies[a].index() < bodies[b].index();  // spheres, capsules, boxes
  });
  return order;
}

}  // namespace lcmslam
