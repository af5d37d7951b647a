#include "procs/map-server/job_thread.hpp"

#include <gmock/gmock.h>

#include <future>
#include <vector>

namespace lcmslam {
namespace {

using ::testing::ElementsAre;

/// Whoever changes the session or moves keyframes is never left out for those that only look.
TEST(JobThread, OnlyWhatMayBeMissedMakesRoom) {
  std::vector<int> done;
  std::promise<void> begun, loaded, last;
  {
    JobThread jobs(true, 3);
    jobs.hand_in([&] {
      begun.set_value();
      loaded.get_future().wait();
    });
    begun.get_future().wait();  // it waits no more
    jobs.hand_in([&] { done.push_back(0); });
    for (int i = 1; i <= 3; ++i) jobs.hand_in_missable([&, i] { done.push_back(i); });
    for (int i = 4; i <= 7; ++i) jobs.hand_in([&, i] { done.push_back(i); });
    jobs.hand_in([&] { last.set_value(); });
    loaded.set_value();
    last.get_future().wait();
  }
  EXPECT_THAT(done, ElementsAre(0, 4, 5, 6, 7));
}

TEST(JobThread, WithoutAThreadEachIsDoneAtOnce) {
  int done = 0;
  JobThread jobs(false, 1);
  jobs.hand_in([&] { ++done; });
  jobs.hand_in_missable([&] { ++done; });
  EXPECT_EQ(done, 2);
}

}  // namespace
}  // namespace lcmslam
