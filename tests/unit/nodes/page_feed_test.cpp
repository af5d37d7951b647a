#include "procs/map-server/page/page_feed.hpp"

#include <nlohmann/json.hpp>

#include "tests/unit/nodes/map_server_fixture.hpp"

namespace lcmslam {
namespace {

class PageFeedTest : public testing::MapServer {
 protected:
  std::size_t shown_at(double now) {
    feed_.show(node_, now);
    return board_.keys("points").size() / point_levels;
  }

  Board board_;
  PageFeed feed_{board_, PageSettings{}};
};

TEST_F(PageFeedTest, TheFirstLookAtALargeMapHoldsUpNobodyLong) {
  pose("ICP_POSE", 1, 1, 1);
  for (std::int32_t id = 0; id < 5; ++id) keyframe(1, id, 20'000);
  EXPECT_EQ(shown_at(0), 2u);
  EXPECT_EQ(shown_at(0.001), 2u) << "after each message, too";
  EXPECT_EQ(shown_at(0.03), 4u) << "not after another map_period";
  EXPECT_EQ(shown_at(0.06), 5u);
  keyframe(1, 5, 20'000);
  EXPECT_EQ(shown_at(0.09), 5u) << "map_period";
  EXPECT_EQ(shown_at(1.01), 6u);
}

/// A drive ahead with truth and wheels, and what the page tells of its errors.
class PageErrors : public PageFeedTest {
 protected:
  PageErrors() { feed_.connect(inputs_); }

  template <class M>
  void hear(const std::string& channel, const M& message) {
    const auto bytes = encode_message(message);
    inputs_.deliver(channel, bytes.data(), bytes.size());
  }
  void truth(double x) {
    ground_truth_t m{};
    m.utime = time();
    m.seq = seq_++;
    m.frame = "world";
    m.child_frame = "robot";
    m.T_frame_child = to_message(planar_pose(x, 0, 0));
    hear("GROUND_TRUTH", m);
  }
  void odometry(double x) {
    odometry_t m = to_message(MotionSample{time(), planar_pose(x, 0, 0), Matrix6d::Identity()}, "wheels");
    m.seq = seq_++;
    hear("ODOMETRY", m);
  }
  void mapper(const std::string& channel, double x, const std::string& frame) {
    pose_estimate_t m = make_pose_estimate(time(), planar_pose(x, 0, 0), Matrix6d::Identity());
    m.seq = seq_++;
    m.sender = sender_;
    m.frame = frame;
    bus_.deliver(channel, m);
  }
  /// The page's poses a tenth of a second later.
  nlohmann::json told() {
    seconds_ += 0.1;
    feed_.show(node_, seconds_);
    return header("poses");
  }
  /// All tell that the robot is at x, m; the mapper in a map that begins at `begin`.
  nlohmann::json drive(double x, double begin, const std::string& frame,
                       const std::string& channel = "ICP_POSE") {
    truth(x);
    odometry(x);
    mapper(channel, x - begin, frame);
    return told();
  }
  nlohmann::json header(const std::string& channel) const {
    for (const Board::Message& message : board_.messages()) {
      const auto size = static_cast<unsigned char>((*message)[0]) | static_cast<unsigned char>((*message)[1])
                                                                        << 8;
      const auto header = nlohmann::json::parse(message->substr(4, static_cast<std::size_t>(size)));
      if (header.at("channel") == channel) return header;
    }
    return {};
  }
  Utime time() const { return static_cast<Utime>(1e6 * (100 + seconds_)); }

  Inputs inputs_;
  double seconds_ = 0;
  std::int64_t sender_ = 1;  // the mapper
};

TEST_F(PageErrors, OdometryIsComparedOnceItHasAPlaceInTheMap) {
  truth(5);
  odometry(5);
  EXPECT_FALSE(told().contains("errors")) << "no mapper has told a pose";
  truth(5);
  odometry(5);
  mapper("ICP_POSE", 0, "map");
  told();
  truth(6);
  odometry(6.1);
  mapper("ICP_POSE", 1, "map");
  EXPECT_NEAR(told().at("errors").at("odometry"), 0.1, 1e-3);
}

TEST_F(PageErrors, ANewMapPlacesOdometryAnew) {
  drive(0, 0, "map");
  keyframe(1, 0, 10);
  drive(4, 0, "map");
  drive(4, 4, "map-2");
  keyframe(1, 0, 10, "map-2");
  drive(4.5, 4, "map-2");
  const auto poses = drive(5, 4, "map-2");
  EXPECT_NEAR(poses.at("odometry").at("T")[0], 1, 1e-3);
  EXPECT_NEAR(poses.at("errors").at("odometry"), 0, 1e-3) << "m; the new map's frame lies 4 m ahead";
}

TEST_F(PageErrors, AMapperThatIsStartedAnewBeginsAMapOfTheSameName) {
  drive(0, 0, "map");
  keyframe(1, 0, 10);
  drive(4, 0, "map");
  const auto points = [&] { return board_.keys("points").empty() ? 0 : header("points").at("n").get<int>(); };
  const int before = points();
  sender_ = 2;
  seconds_ += 5;  // so long nobody else is taken for it
  for (int i = 0; i < 10; ++i) drive(4, 4, "map");
  keyframe(2, 0, 1000);
  drive(4.5, 4, "map");
  const auto poses = drive(5, 4, "map");
  EXPECT_NEAR(poses.at("odometry").at("T")[0], 1, 1e-3);
  EXPECT_NEAR(poses.at("truth").at("T")[0], 1, 1e-3);
  EXPECT_NEAR(poses.at("errors").at("icp"), 0, 1e-3);
  EXPECT_NEAR(poses.at("errors").at("odometry"), 0, 1e-3);
  EXPECT_GT(points(), before) << "the old map's keyframe 0 has gone";
  EXPECT_EQ(header("notices").at("notices")[0].at("words"), "a new map begins: map");
}

TEST_F(PageErrors, ADenseMapBesideLandmarksOfItsFrameIsNoNewOne) {
  drive(0, 0, "map", "FASTSLAM_POSE");
  landmarks(1, 1, 0, {1, 2});
  drive(1, 0, "map", "FASTSLAM_POSE");
  sender_ = 2;
  drive(2, 0, "map");
  keyframe(2, 0, 10);
  truth(3);
  odometry(3.2);
  mapper("ICP_POSE", 3, "map");
  told();
  EXPECT_NEAR(drive(3.2, 0, "map").at("errors").at("odometry"), 0, 1e-3);
  EXPECT_TRUE(header("notices").is_null()) << header("notices");
}

TEST_F(PageErrors, AClockThatIsAheadAndFallsSilentHoldsUpNoPoses) {
  const double now = seconds_;
  seconds_ += 1000;
  odometry(0);
  seconds_ = now;
  mapper("ICP_POSE", 0, "map");
  told();
  mapper("ICP_POSE", 1, "map");
  const Utime utime = time();
  const auto poses = told();
  EXPECT_NEAR(poses.at("icp").at("T")[0], 1, 1e-3);
  EXPECT_EQ(poses.at("utime"), utime);
}

TEST_F(PageErrors, ANewMapOfLandmarksAloneIsNoticed) {
  drive(0, 0, "map", "FASTSLAM_POSE");
  landmarks(1, 1, 0, {1, 2});
  drive(4, 0, "map", "FASTSLAM_POSE");
  drive(4, 4, "map-2", "FASTSLAM_POSE");
  landmarks(1, 1, 0, {1}, {}, "map-2");
  drive(4.5, 4, "map-2", "FASTSLAM_POSE");
  EXPECT_NEAR(drive(5, 4, "map-2", "FASTSLAM_POSE").at("odometry").at("T")[0], 1, 1e-3);
  EXPECT_EQ(header("notices").at("notices")[0].at("words"), "a new map begins: map-2");
}

TEST_F(PageErrors, AreToldWhileTruthAndMapperTellOn) {
  drive(0, 0, "map");
  EXPECT_TRUE(drive(1, 0, "map").at("errors").contains("icp"));
  for (int i = 0; i < 8; ++i) mapper("ICP_POSE", 1 + 0.1 * i, "map"), told();
  EXPECT_TRUE(told().at("errors").contains("icp")) << "truth came 0.8 s ago";
  for (int i = 0; i < 4; ++i) mapper("ICP_POSE", 2, "map"), told();
  EXPECT_FALSE(told().at("errors").contains("icp")) << "truth came 1.2 s ago";
  EXPECT_TRUE(drive(2, 0, "map").at("errors").contains("icp"));
  for (int i = 0; i < 32; ++i) truth(2), odometry(2), told();
  const auto poses = told();
  EXPECT_EQ(poses.at("icp").at("status"), "SILENT");
  EXPECT_FALSE(poses.at("errors").contains("icp"));
  EXPECT_TRUE(poses.at("errors").contains("odometry"));
}

}  // namespace
}  // namespace lcmslam
