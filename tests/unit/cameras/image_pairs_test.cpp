// Pairs of two streams of stamps against the same decided with all stamps known.

#include <lcmslam/cameras/image_pairs.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <set>

#include <lcmslam/cameras/paired_recording.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

using Stamps = std::vector<Utime>;
using Pairs = std::map<Utime, Utime>;  // colour's stamp, depth's

/// The closest pair of all, then the closest of what is left, and so on.
Pairs best_pairs(const Stamps& colours, const Stamps& depths, Utime tolerance) {
  std::vector<std::tuple<Utime, Utime, Utime>> all;
  for (const Utime c : colours)
    for (const Utime d : depths)
      if (std::abs(c - d) <= tolerance) all.emplace_back(std::abs(c - d), c, d);
  std::sort(all.begin(), all.end());
  Pairs pairs;
  std::set<Utime> taken;
  for (const auto& [apart, c, d] : all)
    if (pairs.count(c) == 0 && taken.insert(d).second) pairs[c] = d;
  return pairs;
}

RgbdFrame image(Utime utime) {
  RgbdFrame frame;
  frame.utime = frame.depth_utime = utime;
  return frame;
}

struct Result {
  Pairs pairs;
  PairCounts counts;
  Utime longest_wait = 0;  // from the later image of a pair until it was given
};

struct LatePairs {
  std::size_t count = 0;
  Utime longest_wait = 0;  // in the second half, from a pair's later image until it was given
};

/// Pairs of colour at 60 and depth at 10 Hz, which comes here 80 ms late; after 2 s two depth images are
/// stamped 2 ms one after the other.
LatePairs pairs_of_late_depth(bool hiccup) {
  std::multimap<Utime, std::pair<bool, Utime>> arrivals;  // whether it is depth, and its stamp
  for (int i = 0; i < 3600; ++i)
    arrivals.emplace(1'000'000 + i * 16'667L, std::pair(false, 1'000'000 + i * 16'667L));
  for (int i = 0; i < 600; ++i) {
    const Utime stamp = 1'000'000 + i * 100'000L + (hiccup && i == 20 ? -98'000 : 0);
    arrivals.emplace(stamp + 80'000, std::pair(true, stamp));
  }
  ImagePairs matcher(15'000, 0);
  LatePairs pairs;
  for (const auto& [now, image_of] : arrivals) {
    image_of.first ? matcher.add_depth(image(image_of.second)) : matcher.add_colour(image(image_of.second));
    while (const auto pair = matcher.next()) {
      ++pairs.count;
      if (pairs.count > 300)
        pairs.longest_wait = std::max(pairs.longest_wait, now - (pair->depth_utime + 80'000));
    }
  }
  return pairs;
}

TEST(ImagePairs, AHiccupCostsNoPairsAndIsNotRememberedForGood) {
  const LatePairs even = pairs_of_late_depth(false), after = pairs_of_late_depth(true);
  EXPECT_GE(even.count, 598U);
  EXPECT_GE(after.count, 598U) << "while the pace is not known again, too";
  EXPECT_EQ(after.longest_wait, even.longest_wait);
}

/// Images arrive in the order of their stamps.
Result match(const Stamps& colours, const Stamps& depths, Utime tolerance) {
  ImagePairs matcher(tolerance, 0);
  Result result;
  Utime now = 0;
  const auto take = [&](bool ended) {
    while (const auto pair = matcher.next()) {
      EXPECT_EQ(result.pairs.count(pair->utime), 0U);
      if (!result.pairs.empty()) {
        EXPECT_GT(pair->utime, result.pairs.rbegin()->first);
      }
      result.pairs[pair->utime] = pair->depth_utime;
      const Utime complete = std::max(pair->utime, pair->depth_utime);
      if (!ended) result.longest_wait = std::max(result.longest_wait, now - complete);
    }
  };
  for (std::size_t c = 0, d = 0; c < colours.size() || d < depths.size();) {
    const bool colour = d == depths.size() || (c < colours.size() && colours[c] <= depths[d]);
    now = colour ? colours[c] : depths[d];
    colour ? matcher.add_colour(image(colours[c++])) : matcher.add_depth(image(depths[d++]));
    take(false);
  }
  matcher.finish();
  take(true);
  result.counts = matcher.counts();
  return result;
}

void expect_counts(const Result& result, const Stamps& colours, const Stamps& depths) {
  const auto pairs = static_cast<std::int64_t>(result.pairs.size());
  EXPECT_EQ(result.counts.pairs, pairs);
  EXPECT_EQ(result.counts.unmatched_colour, static_cast<std::int64_t>(colours.size()) - pairs);
  EXPECT_EQ(result.counts.unmatched_depth, static_cast<std::int64_t>(depths.size()) - pairs);
}

Stamps stream(Random& random, Utime start, double period, double jitter, double loss) {
  Stamps stamps;
  for (int i = 0; i < 300; ++i)
    if (random.uniform(0, 1) >= loss)
      stamps.push_back(start + static_cast<Utime>(i * period + random.uniform(-jitter, jitter)));
  return stamps;
}

TEST(ImagePairs, AreTheClosestWhateverBothCamerasPacesAndLosses) {
  std::size_t pairs = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    const double colour_period = random.uniform(0, 1) < 0.5 ? 33'333 : 66'667;
    const double depth_period = random.uniform(0, 1) < 0.5 ? 100'000 : 33'400;
    const auto tolerance = static_cast<Utime>(random.uniform(5'000, 30'000));
    const double jitter =
        random.uniform(0, 1'500);  // a tenth of an interval and more would be a change of pace
    const Stamps colours = stream(random, 1'000'000, colour_period, jitter, 0.05);
    const Stamps depths =
        stream(random, 1'000'000 + static_cast<Utime>(random.uniform(0, 1e5)), depth_period, jitter, 0.05);
    const Result result = match(colours, depths, tolerance);
    EXPECT_EQ(result.pairs, best_pairs(colours, depths, tolerance)) << "seed " << seed;
    expect_counts(result, colours, depths);
    pairs += result.pairs.size();
  }
  EXPECT_GT(pairs, 200U * 50U);
}

TEST(ImagePairs, OfStampsWithoutAnyOrderAreOneToOneAndWithinTheTolerance) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Random random(seed);
    std::set<Utime> c, d;
    for (int i = 0; i < 200; ++i) c.insert(static_cast<Utime>(random.uniform(0, 1e7)));
    for (int i = 0; i < 200; ++i) d.insert(static_cast<Utime>(random.uniform(0, 1e7)));
    const Stamps colours(c.begin(), c.end()), depths(d.begin(), d.end());
    const Result result = match(colours, depths, 20'000);
    std::set<Utime> used;
    for (const auto& [colour, depth] : result.pairs) {
      EXPECT_LE(std::abs(colour - depth), 20'000);
      EXPECT_TRUE(used.insert(depth).second) << "seed " << seed;
    }
    // Few are decided too early: a camera's shortest interval so far is no bound here.
    EXPECT_GE(result.pairs.size() + 10, best_pairs(colours, depths, 20'000).size()) << "seed " << seed;
    expect_counts(result, colours, depths);
  }
}

TEST(ImagePairs, WaitForNoImageThatCannotComeNearer) {
  Stamps colours, depths;
  for (int i = 0; i < 90; ++i) colours.push_back(1'000'000 + i * 33'333);
  for (int i = 0; i < 30; ++i) depths.push_back(1'004'000 + i * 100'000);
  const Result result = match(colours, depths, 15'000);
  EXPECT_EQ(result.pairs.size(), 30U);
  for (const auto& [colour, depth] : result.pairs)
    EXPECT_EQ(depth - colour, 4'000 + (depth - 1'004'000) / 100'000);
  EXPECT_LE(result.longest_wait, 100'000) << "the first, before anything is known of both paces";
  const Result later = match(Stamps(colours.begin(), colours.end()), depths, 15'000);
  EXPECT_EQ(later.counts.unmatched_colour, 60);
}

TEST(ImagePairs, OfOneCameraThatFallsSilentAreNotWaitedForForEver) {
  ImagePairs matcher(20'000, 0);
  matcher.add_depth(image(1'000'000));
  for (int i = 0; i < 100; ++i) matcher.add_colour(image(1'000'000 + i * 33'000));
  int pairs = 0;
  while (matcher.next()) ++pairs;
  EXPECT_EQ(pairs, 1);
  EXPECT_EQ(matcher.counts().unmatched_colour, 89) << "all but the pair and the last 0.3 s";
}

// 100 Hz, depth 0.2 s late and without a pace to rely on; once it stalls for another 0.2 s.
TEST(ImagePairs, OfPartnersThatComeLateAreMadeButForThoseThatAreTooLate) {
  ImagePairs matcher(5'000, 0);
  int pairs = 0;
  int next_depth = 0;
  for (int i = 0; i < 500; ++i) {
    matcher.add_colour(image(1'000'000 + i * 10'000));
    const bool stalls = i >= 250 && i < 270;
    for (; next_depth <= i - 20 && !stalls; ++next_depth)
      matcher.add_depth(image(1'000'000 + next_depth * 10'000 - 1'000 * (next_depth % 3)));
    while (matcher.next()) ++pairs;
  }
  EXPECT_NEAR(static_cast<double>(matcher.counts().unmatched_colour), 10, 2);
  EXPECT_GE(pairs, 465);
}

TEST(ImagePairs, TakeTheDepthImageWithItsStampAndAmplitude) {
  ImagePairs matcher(20'000, 0);
  RgbdFrame colour = image(1'000'000), depth = image(1'003'000);
  colour.colour = cv::Mat(4, 4, CV_8UC3, cv::Scalar(1, 2, 3));
  depth.depth = cv::Mat(2, 2, CV_16UC1, cv::Scalar(777));
  depth.amplitude = cv::Mat(2, 2, CV_8UC1, cv::Scalar(9));
  matcher.add_colour(colour);
  matcher.add_depth(depth);
  EXPECT_FALSE(matcher.next()) << "a nearer colour image may come";
  matcher.finish();
  const auto pair = matcher.next();
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->utime, 1'000'000);
  EXPECT_EQ(pair->depth_utime, 1'003'000);
  EXPECT_EQ(pair->colour.at<cv::Vec3b>(0, 0), cv::Vec3b(1, 2, 3));
  EXPECT_EQ(pair->depth.at<std::uint16_t>(1, 1), 777);
  EXPECT_EQ(pair->amplitude.at<std::uint8_t>(1, 1), 9);
}

/// A recording of images that are there at once.
class Recording : public CameraDevice {
 public:
  Recording(Stamps stamps, bool depth) : stamps_(std::move(stamps)), depth_(depth) {}
  std::optional<CameraShot> read(std::chrono::milliseconds) override {
    if (next_ == stamps_.size()) {
      ended_ = true;
      return std::nullopt;
    }
    RgbdFrame frame = image(stamps_[next_++]);
    (depth_ ? frame.depth : frame.colour) = cv::Mat(1, 1, depth_ ? CV_16UC1 : CV_8UC3);
    return frame;
  }
  bool ended() const override { return ended_; }
  std::string describe() const override { return depth_ ? "depth" : "colour"; }

 private:
  Stamps stamps_;
  bool depth_, ended_ = false;
  std::size_t next_ = 0;
};

TEST(PairedRecording, GivesAllPairsOfTwoRecordingsToTheirEnd) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    const Stamps colours = stream(random, 1'000'000, 33'333, 1000, 0.1);
    const Stamps depths = stream(random, 2'000'000, 33'400, 1000, 0.1);  // begins and ends a second later
    PairedRecording recording(std::make_unique<Recording>(colours, false),
                              std::make_unique<Recording>(depths, true), ImagePairs(12'000, 0));
    Pairs pairs;
    while (true) {
      const auto frame = recording.read(std::chrono::milliseconds(0));
      if (!frame && recording.ended()) break;
      if (!frame) continue;
      EXPECT_FALSE(frame->colour.empty());
      EXPECT_FALSE(frame->depth.empty());
      pairs[frame->utime] = frame->depth_utime;
    }
    EXPECT_EQ(pairs, best_pairs(colours, depths, 12'000)) << "seed " << seed;
    EXPECT_GT(pairs.size(), 100U);
  }
}

TEST(ImagePairs, ATimeThatBeginsAnewIsFollowedAndSayHowFarTheNearestWas) {
  ImagePairs matcher(20'000, 0);
  for (int i = 0; i < 20; ++i) {
    matcher.add_colour(image(50'000'000 + i * 100'000));
    matcher.add_depth(image(50'040'000 + i * 100'000));
  }
  EXPECT_FALSE(matcher.next());
  EXPECT_EQ(matcher.last_miss(), 40'000);
  matcher.add_colour(image(1'000'000));
  matcher.add_depth(image(1'000'000));
  matcher.add_colour(image(1'100'000));
  matcher.add_depth(image(1'100'000));
  EXPECT_TRUE(matcher.next());
  matcher.add_colour(image(1'050'000));  // late by little: refused
  const PairCounts counts = matcher.counts();
  EXPECT_EQ(counts.unmatched_colour, 21);
  EXPECT_EQ(counts.unmatched_depth, 20);
}

/// Depth stamps by a clock of its own.
Pairs shifted(const Pairs& pairs, Utime offset) {
  Pairs result;
  for (const auto& [colour, depth] : pairs) result[colour] = depth + offset;
  return result;
}

TEST(ImagePairs, AreTheSameByWhateverClockDepthIsStamped) {
  for (const Utime offset : {-80'000, -20'000, 70'000, 1'500'000}) {
    Random random(3);
    const Stamps colours = stream(random, 9'000'000, 33'333, 1000, 0.1);
    Stamps depths = stream(random, 9'000'000, 33'400, 1000, 0.1);
    const Pairs wanted = shifted(best_pairs(colours, depths, 12'000), -offset);
    ImagePairs matcher(12'000, offset);
    Pairs found;
    for (std::size_t c = 0, d = 0; c < colours.size() || d < depths.size();) {  // as they are taken
      if (d == depths.size() || (c < colours.size() && colours[c] <= depths[d]))
        matcher.add_colour(image(colours[c++]));
      else
        matcher.add_depth(image(depths[d++] - offset));
      while (const auto pair = matcher.next()) found[pair->utime] = pair->depth_utime;
    }
    matcher.finish();
    while (const auto pair = matcher.next()) found[pair->utime] = pair->depth_utime;
    EXPECT_EQ(found, wanted) << offset;

    for (Utime& stamp : depths) stamp -= offset;
    PairedRecording recording(std::make_unique<Recording>(colours, false),
                              std::make_unique<Recording>(depths, true), ImagePairs(12'000, offset));
    found.clear();
    while (const auto frame = recording.read(std::chrono::milliseconds(0)))
      found[frame->utime] = frame->depth_utime;
    EXPECT_EQ(found, wanted) << offset;
  }
}

}  // namespace
}  // namespace lcmslam
