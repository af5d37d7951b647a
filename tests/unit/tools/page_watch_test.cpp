#include "tools/launch/page_watch.hpp"

#include <gmock/gmock.h>

#include <fstream>

#include "tests/unit/tools/scratch.hpp"

namespace lcmslam {
namespace {

class PageWatchTest : public ::testing::Test {
 protected:
  void append(const std::string& text) const { std::ofstream(log_, std::ios::app) << text; }

  testing::ScratchFolder scratch_;
  const std::filesystem::path log_ = scratch_.path() / "map-server.txt";
};

TEST_F(PageWatchTest, TellsTheAddressOnceWhenItsLineIsWhole) {
  PageWatch watch(log_);
  EXPECT_EQ(watch.news(), "") << "there is no log yet";
  append("[now] [map-server] [info] the live page: http://robot:86");
  EXPECT_EQ(watch.news(), "");
  append("42/?token=abc\n[now] [map-server] [info] maps saved\n");
  EXPECT_EQ(watch.news(), "the live page: http://robot:8642/?token=abc");
  EXPECT_EQ(watch.news(), "");
  append("[now] [map-server] [info] maps saved\n");
  EXPECT_EQ(watch.news(), "");
  EXPECT_EQ(watch.last(), "the live page: http://robot:8642/?token=abc");
}

TEST_F(PageWatchTest, TellsWhatAServerThatStartedAgainSaysAlsoInALogThatBeganAnew) {
  append("the live page: http://of-another-run:1/\n");
  PageWatch watch(log_);
  append("the live page: http://robot:8642/?token=abc\n");
  EXPECT_EQ(watch.news(), "the live page: http://robot:8642/?token=abc");
  std::filesystem::resize_file(log_, 0);
  append("the live page: http://robot:1/?token=d\n");
  EXPECT_EQ(watch.news(), "the live page: http://robot:1/?token=d");
  append("there is no live page, mapping goes on: port 1 is taken\n");
  EXPECT_EQ(watch.news(), "there is no live page, mapping goes on: port 1 is taken");
}

}  // namespace
}  // namespace lcmslam
