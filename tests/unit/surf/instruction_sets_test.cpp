// The loops compiled for AVX2 against those for the baseline: the same bits.
#include <lcmslam/parallel/instruction_set.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include <lcmslam/surf/surf.hpp>
#include "tests/unit/surf/blob_scene.hpp"

namespace lcmslam {
namespace {

class Limited {
 public:
  explicit Limited(InstructionSet best) : before_(limit_instruction_set(best)) {}
  ~Limited() { limit_instruction_set(before_); }
  Limited(const Limited&) = delete;
  Limited& operator=(const Limited&) = delete;

 private:
  InstructionSet before_;
};

struct Described {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
};

Described compute(InstructionSet best, const SurfSettings& settings, const cv::Mat& image,
                  std::vector<cv::KeyPoint> provided = {}) {
  const Limited limited(best);
  Described found{std::move(provided), {}};
  Surf(settings).detectAndCompute(image, cv::noArray(), found.keypoints, found.descriptors,
                                  !found.keypoints.empty());
  return found;
}

void expect_same_bits(const Described& a, const Described& b) {
  ASSERT_EQ(a.keypoints.size(), b.keypoints.size());
  for (std::size_t i = 0; i < a.keypoints.size(); ++i) {
    const cv::KeyPoint &p = a.keypoints[i], &q = b.keypoints[i];
    ASSERT_EQ(p.pt, q.pt);
    ASSERT_EQ(p.size, q.size);
    ASSERT_EQ(p.angle, q.angle) << "at " << p.pt << ", size " << p.size;
    ASSERT_EQ(p.response, q.response);
    ASSERT_EQ(p.octave, q.octave);
    ASSERT_EQ(p.class_id, q.class_id);
  }
  ASSERT_EQ(a.descriptors.size(), b.descriptors.size());
  if (a.descriptors.empty()) return;
  ASSERT_EQ(std::memcmp(a.descriptors.data, b.descriptors.data, a.descriptors.total() * sizeof(float)), 0);
}

class SurfInstructionSets : public testing::Test {
 protected:
  void SetUp() override {
    if (best_instruction_set() != InstructionSet::avx2) GTEST_SKIP() << "this processor has no AVX2";
  }
};

TEST_F(SurfInstructionSets, TheLimitHolds) {
  {
    const Limited limited(InstructionSet::portable);
    EXPECT_EQ(best_instruction_set(), InstructionSet::portable);
  }
  EXPECT_EQ(best_instruction_set(), InstructionSet::avx2);
}

TEST_F(SurfInstructionSets, GiveTheSameBits) {
  std::vector<SurfSettings> all(4);
  for (SurfSettings& settings : all) settings.budget.max_features = 0;
  all[1].extended = true;
  all[1].octaves = 6;
  all[2].upright = true;
  all[2].intervals = 6;
  all[3].edge_ratio = 1e6;
  all[3].hessian_threshold = 0;
  std::size_t compared = 0;
  for (const cv::Size size : {cv::Size(487, 361), cv::Size(200, 133), cv::Size(33, 300)}) {
    cv::Mat image = test::random_scene(31, 250).draw(size.width, size.height, {1, 0, 240, 180});
    for (const bool noisy : {false, true}) {
      if (noisy) {
        cv::RNG random(5);
        random.fill(image, cv::RNG::UNIFORM, 0, 256);
      }
      for (const SurfSettings& settings : all) {
        const Described avx2 = compute(InstructionSet::avx2, settings, image);
        compared += avx2.keypoints.size();
        expect_same_bits(avx2, compute(InstructionSet::portable, settings, image));
      }
    }
  }
  EXPECT_GT(compared, 3000u);
}

// Any size, at and beyond the border, and numbers with which nothing can be computed.
TEST_F(SurfInstructionSets, AgreeOnAnyKeypoint) {
  const cv::Mat image = test::random_scene(32, 100).draw(151, 120, {1, 0, 75, 60});
  std::vector<cv::KeyPoint> provided;
  Random random(33);
  for (int i = 0; i < 500; ++i)
    provided.emplace_back(float(random.uniform(-30, 180)), float(random.uniform(-30, 150)),
                          float(std::exp(random.uniform(-3, 8))), float(random.uniform(-90, 360)));
  for (const float huge : {1e9f, 1e38f})
    for (const float size : {1e-30f, 20.f, huge}) {
      provided.emplace_back(huge, 10.f, size);
      provided.emplace_back(10.f, -huge, size, 77.f);
    }
  for (const bool extended : {false, true}) {
    SurfSettings settings;
    settings.extended = extended;
    const Described avx2 = compute(InstructionSet::avx2, settings, image, provided);
    expect_same_bits(avx2, compute(InstructionSet::portable, settings, image, provided));
    EXPECT_TRUE(cv::checkRange(avx2.descriptors));
    for (const cv::KeyPoint& k : avx2.keypoints) {
      EXPECT_GE(k.angle, 0);
      EXPECT_LE(k.angle, 360);
    }
  }
}

}  // namespace
}  // namespace lcmslam
