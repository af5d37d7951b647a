// What processes do about images and features of different times: a depth camera's clock that is off,
// features that come late, the motion between colour and depth, rows that are read one after another.

#include <gmock/gmock.h>

#include <algorithm>
#include <lcmslam/graph_t.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/keyframe_t.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include "procs/icp/icp_node.hpp"
#include "tests/support/recorded_drive.hpp"
#include "tests/support/simulated_kitchen.hpp"

namespace lcmslam {
namespace {

using testing::RecordedDrive;
using testing::SimulatedKitchen;
using testing::TestBus;

/// What `icp` learned of the depth clock when the calibration is wrong by `seconds`: the offset and its
/// sigma.
std::pair<double, double> learned_clock(double seconds) {
  TestBus bus;
  bus.add<OdometryNode>();
  const IcpNode& icp = bus.add<IcpNode>(ConfigNode::parse("{depth_clock: {prior: 0.01}}"));
  RecordedDrive::Part part;
  part.from = RecordedDrive::turns;
  part.with_features = true;
  part.change_calibration = [&](camera_calibration_t& m) { m.depth_clock_offset += seconds; };
  RecordedDrive::instance().play(bus, part);
  bus.finish();
  return {testing::value_of(icp, "depth_clock_offset"), testing::value_of(icp, "depth_clock_sigma")};
}

// A bend tells little of it: where the robot turns steadily, the map errs like the cloud.
TEST(DepthClockOfTheProcess, MovesAgainstTheCalibrationsError) {
  const auto [right, sigma] = learned_clock(0);
  const double late = learned_clock(0.04).first, early = learned_clock(-0.04).first;
  std::cout << "learned " << right << " +- " << sigma << ", " << late << ", " << early << " s\n";
  EXPECT_LT(std::abs(right), 0.004);
  EXPECT_LT(sigma, 0.0085);         // the prior's is 0.01
  EXPECT_GT(early - late, 0.0007);  // by less than a tenth of its sigma: one bend; either alone may stay
}

/// Edges of the last graph that lead farther back than to the node before.
int circles(const TestBus& bus) {
  const auto graphs = bus.on<graph_t>("ICP_GRAPH");
  if (graphs.empty()) return 0;
  const graph_t& graph = graphs.back();
  std::map<int, int> place;
  for (const graph_node_t& node : graph.nodes) place[node.keyframe] = static_cast<int>(place.size());
  return static_cast<int>(std::count_if(graph.edges.begin(), graph.edges.end(), [&](const graph_edge_t& e) {
    return std::abs(place.at(e.to_node) - place.at(e.from_node)) > 1;
  }));
}

TEST(LateFeatures, ReachTheirKeyframes) {
  // Neighbours and surfaces that are shown again are not looked for, so that only features find circles.
  const auto circles_with = [](bool with_features, double late) {
    TestBus bus;
    bus.add<OdometryNode>();
    const IcpNode& icp = bus.add<IcpNode>(ConfigNode::parse("{graph: {neighbours: 0, shown: 0}}"));
    RecordedDrive::Part part;
    part.with_features = with_features;
    part.features_late = late;
    RecordedDrive::instance().play(bus, part);
    bus.finish();
    EXPECT_EQ(testing::value_of(icp, "with_features") > 0, with_features && late == 0);
    return circles(bus);
  };
  EXPECT_EQ(circles_with(false, 0), 0);
  EXPECT_GT(circles_with(true, 0), 10);
  EXPECT_GT(circles_with(true, 0.15), 10);  // behind their step, before the graph's patience ends
}

/// The kitchen from a moment when the robot drives and turns.
class Turning : public ::testing::Test {
 protected:
  static constexpr Utime begin = 10'500'000;  // us after the start: about 30 degrees a second

  void SetUp() override { bus_.add<OdometryNode>(); }

  Utime at(Utime since_begin) const { return simulation_.start() + begin + since_begin; }
  Eigen::Isometry3d T_world_camera(Utime utime) const {
    return simulation_.T_world_robot(utime) * simulation_.calibration().T_robot_camera;
  }
  void play_encoders(Utime from, Utime to) {
    for (Utime t = from; t <= to; t += 20'000) bus_.deliver("ENCODERS", to_message(simulation_.encoders(t)));
  }
  void deliver(const RgbdFrame& frame, int seq) {
    EncodedFrame encoded = encode(frame);
    encoded.sensor = simulation_.calibration().sensor;
    images_t message = to_message(encoded);
    set_origin(message, {seq, 1000});
    bus_.deliver("CAMERA", message);
  }
  double median_distance(const std::vector<Eigen::Vector3d>& points_world) const {
    std::vector<double> distances;
    for (const auto& p : points_world) distances.push_back(simulation_.distance_to_surface(p));
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    return *middle;
  }

  SimulatedKitchen& kitchen_ = SimulatedKitchen::instance();
  const Simulation& simulation_ = kitchen_.simulation();
  TestBus bus_;
};

TEST_F(Turning, FeaturesStandWhereTheColourCameraWas) {
  bus_.add<SurfNode>();
  bus_.deliver("CAMERA_CALIBRATION", kitchen_.calibration());
  constexpr Utime apart = 200'000;  // us from the colour to the depth image
  play_encoders(at(-100'000), at(apart + 60'000));
  RgbdFrame frame = simulation_.render(at(0));
  const RgbdFrame later = simulation_.render(at(apart));
  frame.depth = later.depth;
  frame.amplitude = later.amplitude;
  frame.depth_utime = later.depth_utime;
  deliver(frame, 0);
  const FeatureFrame features = from_message(bus_.on<features_t>("FEATURES").at(0));
  std::vector<Eigen::Vector3d> points;
  for (const Feature& f : features.features)
    if (f.kind == MeasurementKind::point) points.push_back(T_world_camera(at(0)) * f.point.cast<double>());
  ASSERT_GT(points.size(), 100U);
  const double distance = median_distance(points);
  std::cout << "features " << distance << " m off the surfaces\n";
  EXPECT_LT(distance, 0.012);
}

TEST_F(Turning, RowsThatAreReadOneAfterAnotherAreStraightened) {
  constexpr Utime readout = 100'000;  // us from the first row to the last
  bus_.add<IcpNode>();
  RgbdCalibration calibration = simulation_.calibration();
  calibration.rolling_shutter = 1e-6 * static_cast<double>(readout);
  camera_calibration_t message = to_message(calibration);
  message.utime = kitchen_.calibration().utime;
  bus_.deliver("CAMERA_CALIBRATION", message);
  Utime told = at(-100'000);
  for (int k = 0; k < 3; ++k) {
    const Utime utime = at(300'000 * k);
    play_encoders(told, utime + 100'000);
    told = utime + 120'000;
    RgbdFrame frame = simulation_.render(utime);
    constexpr int bands = 10;
    const int rows = frame.depth.rows;
    for (int b = 0; b < bands; ++b) {
      const cv::Range band(rows * b / bands, rows * (b + 1) / bands);
      const Utime shift = static_cast<Utime>(((b + 0.5) / bands - 0.5) * readout);
      // The simulation's depth image has a time of its own; here rows lie around the colour image's.
      const RgbdFrame there = simulation_.render(utime + shift - (frame.depth_utime - frame.utime));
      there.depth.rowRange(band).copyTo(frame.depth.rowRange(band));
      there.amplitude.rowRange(band).copyTo(frame.amplitude.rowRange(band));
    }
    frame.depth_utime = utime;
    deliver(frame, k);
  }
  bus_.finish();
  std::vector<Eigen::Vector3d> points;
  for (const keyframe_t& m : bus_.on<keyframe_t>("ICP_KEYFRAME")) {
    if (m.utime <= at(0)) continue;  // nothing is known of the motion before the first
    const KeyframeTile tile = from_message(m);
    for (const auto& p : tile.part.cloud.points) points.push_back(T_world_camera(m.utime) * p.cast<double>());
  }
  ASSERT_GT(points.size(), 1000U);
  const double distance = median_distance(points);
  std::cout << "keyframes " << distance << " m off the surfaces\n";
  EXPECT_LT(distance, 0.012);
}

}  // namespace
}  // namespace lcmslam
