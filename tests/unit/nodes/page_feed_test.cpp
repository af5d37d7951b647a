#include "procs/map-server/page/page_feed.hpp"

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

}  // namespace
}  // namespace lcmslam
