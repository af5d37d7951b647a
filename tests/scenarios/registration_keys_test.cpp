// Every part of the modern registration can be chosen in YAML: each value of each key registers a
// bend of the simulated kitchen's drive, differs from the default, and what does not exist is refused.

#include <gmock/gmock.h>

#include <algorithm>
#include <iostream>

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include "procs/icp/icp_node.hpp"
#include "procs/odometry/odometry_node.hpp"
#include "tests/support/recorded_drive.hpp"

namespace lcmslam {
namespace {

using testing::RecordedDrive;
using testing::TestBus;

constexpr double usual = 0.5;

/// Of both passes; `more`: of the section icp.
struct Key {
  std::string pass;
  std::string more;
  double share = usual;     // of odometry's error, at most
  bool is_default = false;  // the value is the default's
};

// The default errs by 0.27 of odometry's error; points without normals or weights and borders that are left
// out tell less.
constexpr double less = 0.7;

// Free space whose noise takes surfels away.
constexpr const char* intolerant = "sigmas: 0, tolerance: 0, lateral: 0, rotation: 1";

std::vector<Key> keys() {
  std::vector<Key> all;
  all.push_back({"selection: uniform", "", usual, true});
  for (const char* selection : {"all", "random", "normal_space", "stable"})
    all.push_back({std::string("selection: ") + selection, ""});
  all.push_back({"", "correspondence: voxel_map", usual, true});
  all.push_back({"", "correspondence: kd_tree", usual, true});  // finds the same
  for (const char* correspondence : {"projective", "normal_shooting"})
    all.push_back({"", std::string("correspondence: ") + correspondence});
  for (const char* metric : {"point_to_point", "point_to_plane", "plane_to_plane"})
    for (const char* solver : {"gauss_newton", "levenberg_marquardt"}) {
      const bool is_default =
          std::string(metric) == "point_to_plane" && std::string(solver) == "gauss_newton";
      all.push_back({std::string("metric: ") + metric + ", solver: " + solver, "", less, is_default});
    }
  for (const char* solver : {"svd", "svd_uncorrected", "quaternion", "small_angle", "small_angle_as_printed"})
    all.push_back({std::string("metric: point_to_point, solver: ") + solver, "", less});
  for (const char* kernel : {"none", "huber", "geman_mcclure"})
    all.push_back({std::string("kernel: ") + kernel + ", kernel_width: 2", ""});
  for (const char* rejection :
       {"distance_sigmas: 0", "distance_sigmas: 2.5", "max_distance: 0.1, min_distance: 0.03",
        "max_normal_angle: 0.4", "max_normal_angle: 3.1416", "mutual: true", "frustum: true",
        "colour_overlap: true"})
    all.push_back({rejection, ""});
  all.push_back({"trimmed_fraction: 0.8", "", 0.8});
  for (const char* correspondence : {"kd_tree", "projective", "normal_shooting"}) {
    const std::string more = std::string("correspondence: ") + correspondence;
    all.push_back({"boundary: true", more, less});
    all.push_back({"colour_scale: 0.1", more});
  }
  all.push_back({"colour_scale: 0.1", ""});
  all.push_back({"colour_scale: 0.1, metric: plane_to_plane", ""});
  // At three frames a second the images of a bend are some hundred pixels apart.
  all.push_back({"colour_overlap: true", "overlap: {columns: 6, rows: 4, scale: 0.125, search: 250}"});
  all.push_back({"weigh_by_noise: false", "", less});
  all.push_back({"noise_floor: 0.01", ""});
  for (const char* stop : {"max_iterations: 3", "epsilon_translation: 0.001, epsilon_rotation: 0.001",
                           "epsilon_rms: 1e-3", "min_pairs: 100"})
    all.push_back({stop, "", usual, std::string(stop) == "min_pairs: 100"});  // there are always more
  for (const char* solving : {"degenerate_share: 0.02", "independent_pairs: 1000"})
    all.push_back({solving, ""});
  all.push_back({"selection: random, seed: 7, selected_points: 900", ""});
  // Nothing leaves this kitchen, unless noise suffices for that.
  all.push_back({"", std::string("free_space: {") + intolerant + "}"});
  all.push_back({"", std::string("free_space: {enabled: false, ") + intolerant + "}", usual, true});
  return all;
}

ConfigNode config_of(const Key& key) {
  return ConfigNode::parse("{coarse: {" + key.pass + "}, fine: {" + key.pass + "}" +
                           (key.more.empty() ? "" : ", " + key.more) + "}");
}

void PrintTo(const Key& key, std::ostream* out) {
  *out << "{" << key.pass << "} " << key.more;
}

/// Poses of a bend of 170 degrees by odometry with noise, and their error as a share of odometry's.
struct Bend {
  std::vector<pose_estimate_t> poses;
  double share = 0;
};

Bend drive_the_bend(const ConfigNode& config) {
  TestBus bus;
  bus.add<OdometryNode>(ConfigNode::parse(testing::noisy_odometry));
  bus.add<IcpNode>(config);
  RecordedDrive& drive = RecordedDrive::instance();
  RecordedDrive::Part part;
  part.from = RecordedDrive::turns;
  part.to = RecordedDrive::turned;
  drive.play(bus, part);
  bus.finish();
  return {bus.on<pose_estimate_t>("ICP_POSE"), drive.share_of_odometry(bus, "ICP_POSE")};
}

const Bend& bend_by_default() {
  static const Bend bend = drive_the_bend({});
  return bend;
}

bool same_poses(const Bend& a, const Bend& b) {
  return std::equal(a.poses.begin(), a.poses.end(), b.poses.begin(), b.poses.end(),
                    [](const auto& x, const auto& y) { return encode_message(x) == encode_message(y); });
}

class RegistrationKeys : public ::testing::TestWithParam<Key> {};
INSTANTIATE_TEST_SUITE_P(Keys, RegistrationKeys, ::testing::ValuesIn(keys()));

TEST_P(RegistrationKeys, RegisterTheKitchen) {
  const Key& key = GetParam();
  const Bend bend = drive_the_bend(config_of(key));
  std::cout << bend.share << " of odometry's error\n";
  EXPECT_LT(bend.share, key.share);
  EXPECT_EQ(same_poses(bend, bend_by_default()), key.is_default)
      << "the key has no effect, or the default another";
  for (const pose_estimate_t& m : bend.poses) {
    EXPECT_NE(m.status, pose_estimate_t::LOST);
    EXPECT_TRUE(&m == &bend.poses.front() || m.inliers > 30) << m.inliers;
  }
}

TEST(RegistrationKeysOfTheMap, EvidenceDecidesWhatLeaves) {
  const std::string space = std::string("{free_space: {") + intolerant + "}";
  const Bend usual_map = drive_the_bend(ConfigNode::parse(space + "}"));
  const Bend patient_map = drive_the_bend(ConfigNode::parse(space + ", map: {miss: 1, dropped_at: -100}}"));
  EXPECT_FALSE(same_poses(usual_map, patient_map));
  EXPECT_LT(patient_map.share, usual);
}

// What is chosen arrives; each value differs from its default.
TEST(RegistrationKeySettings, AreRead) {
  const DenseMapperSettings s = read_settings<DenseMapperSettings>(ConfigNode::parse(
      "{coarse: {frustum: true, seed: 9, min_pairs: 11}, fine: {colour_overlap: true, colour_scale: 0.2, "
      "epsilon_rms: 0.001, degenerate_share: 0.05, independent_pairs: 77}, overlap: {columns: 5}, "
      "free_space: {rotation: 5}, map: {miss: 3}}"));
  EXPECT_TRUE(s.coarse.frustum);
  EXPECT_FALSE(s.fine.frustum);
  EXPECT_EQ(s.coarse.seed, 9U);
  EXPECT_EQ(s.coarse.min_pairs, 11);
  EXPECT_TRUE(s.fine.colour_overlap);
  EXPECT_EQ(s.fine.colour_scale, 0.2);
  EXPECT_EQ(s.fine.epsilon_rms, 0.001);
  EXPECT_EQ(s.fine.degenerate_share, 0.05);
  EXPECT_EQ(s.fine.independent_pairs, 77);
  EXPECT_EQ(s.overlap.columns, 5);
  EXPECT_EQ(s.free_space.rotation, 5);
  EXPECT_EQ(s.map.miss, 3);
  EXPECT_TRUE(s.uses_colour());
  EXPECT_TRUE(s.compares_images());
}

TEST(RegistrationKeySettings, WhatDoesNotExistIsRefused) {
  for (const char* wrong :
       {"{fine: {boundary: true}}", "{fine: {solver: svd}}",
        "{fine: {metric: point_to_point, solver: svd, colour_scale: 0.1}}", "{fine: {colour_scale: -1}}",
        "{fine: {frustum: 3}}", "{free_space: {rotation: 0}}", "{map: {dropped_at: 1}}",
        "{overlap: {scale: 2}}", "{fine: {selection: best}}"}) {
    TestBus bus;
    EXPECT_THROW(bus.add<IcpNode>(ConfigNode::parse(wrong)), ConfigError) << wrong;
  }
  // Only the mapper's own passes have views and colours to compare.
  for (const char* unknown : {"{graph: {loops: {registration: {frustum: true}}}}",
                              "{thesis: {registration: {colour_scale: 1}}}", "{fine: {colour: 1}}"}) {
    const ConfigNode config = ConfigNode::parse(unknown);
    read_settings<DenseMapperSettings>(config);
    EXPECT_THROW(config.finish(), ConfigError) << unknown;
  }
}

}  // namespace
}  // namespace lcmslam
