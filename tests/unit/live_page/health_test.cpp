#include <lcmslam/live_page/health.hpp>

#include <gtest/gtest.h>

namespace lcmslam {
namespace {

ProcessSaid running(const std::string& name) {
  ProcessSaid said;
  said.name = name;
  said.state = "running";
  said.latency_p95 = 0.05;
  return said;
}

std::string level(const PageItem& item) {
  return item.header["level"];
}
std::string words(const PageItem& item) {
  return item.header["words"];
}

TEST(Health, AllIsWellWhereNothingIsWrong) {
  Health health;
  const PageItem item = health.item({running("icp")}, {{"icp", "TRACKING", ""}}, 0);
  EXPECT_EQ(level(item), "good");
  EXPECT_EQ(words(item), "all is well");
  EXPECT_EQ(words(Health().item({}, {}, 0)), "no process has spoken yet");
}

TEST(Health, TheWorstIsSaidFirstWithWhatMendsIt) {
  Health health;
  ProcessSaid silent = running("surf");
  silent.age = 5;
  const PageItem item = health.item({running("icp"), silent},
                                    {{"fastslam", "DEGRADED", "few landmarks"}, {"icp", "TRACKING", ""}}, 0);
  EXPECT_EQ(level(item), "bad");
  EXPECT_EQ(words(item), "surf has been silent for 5 s");
  EXPECT_NE(item.header["mend"], "");
  EXPECT_EQ(item.header["processes"][0]["level"], "good");
  EXPECT_EQ(item.header["processes"][1]["level"], "bad");
}

TEST(Health, MappersThatAreLostOrUnsureAreTold) {
  EXPECT_EQ(level(Health().item({}, {{"icp", "LOST", ""}}, 0)), "bad");
  const PageItem unsure = Health().item({}, {{"icp", "DEGRADED", "a bare wall"}}, 0);
  EXPECT_EQ(level(unsure), "warn");
  EXPECT_NE(words(unsure).find("a bare wall"), std::string::npos);
}

TEST(Health, AMapperThatTellsNothingAnyMoreIsNotWell) {
  ProcessSaid icp = running("icp"), camera = running("camera");
  icp.detail = "CAMERA comes no more";
  const std::vector<MapperSaid> silent = {{"icp", "SILENT", ""}};
  const PageItem item = Health().item({camera, icp}, silent, 0);
  EXPECT_EQ(level(item), "bad");
  EXPECT_EQ(words(item), "icp tells no position any more: CAMERA comes no more");
  camera.age = 5;
  EXPECT_EQ(words(Health().item({camera, icp}, silent, 0)), "camera has been silent for 5 s") << "the cause";
  camera.age = 0;
  camera.state = "finished";
  EXPECT_EQ(level(Health().item({camera, icp}, silent, 0)), "good") << "its log is at its end";
}

TEST(Health, WhoWasEndedIsToldForAMinute) {
  ProcessSaid bridge = running("bridge");
  bridge.state = "stopping";
  bridge.age = 5;
  const PageItem item = Health().item({bridge}, {}, 0);
  EXPECT_EQ(level(item), "warn");
  EXPECT_EQ(words(item), "bridge has been ended");
  bridge.age = 70;
  EXPECT_EQ(level(Health().item({bridge}, {}, 0)), "good");
  bridge.state = "running";
  EXPECT_EQ(level(Health().item({bridge}, {}, 0)), "bad") << "it was killed";
}

TEST(Health, LossesAreToldWhileTheyRiseAndForgivenLater) {
  Health health;
  ProcessSaid losing = running("icp");
  losing.dropped = 2;
  EXPECT_EQ(level(health.item({losing}, {}, 0)), "good") << "a few at the start are nobody's fault";
  losing.dropped = 20;
  EXPECT_EQ(level(health.item({losing}, {}, 1)), "warn");
  EXPECT_EQ(level(health.item({losing}, {}, 10)), "warn");
  EXPECT_EQ(level(health.item({losing}, {}, 17)), "good");
  losing.dropped = 21;
  EXPECT_EQ(level(health.item({losing}, {}, 18)), "warn");
}

TEST(Health, AProcessThatBeganAnewCountsFromNothing) {
  Health health;
  ProcessSaid said = running("icp");
  said.lost = 100;
  health.item({said}, {}, 0);
  said.lost = 0;
  health.item({said}, {}, 100);
  said.lost = 30;
  EXPECT_EQ(level(health.item({said}, {}, 101)), "warn");
}

TEST(Health, LatenessAndFailureAreTold) {
  ProcessSaid late = running("icp");
  late.latency_p95 = 0.4;
  EXPECT_EQ(words(Health().item({late}, {}, 0)), "icp answers late: 400 ms");
  ProcessSaid failed = running("camera");
  failed.state = "failed";
  failed.detail = "no such device";
  EXPECT_EQ(words(Health().item({failed}, {}, 0)), "camera failed: no such device");
}

}  // namespace
}  // namespace lcmslam
