#pragma once
// Our features of recorded images, and a map merged from them: what an index of descriptors meets in
// earnest. Random vectors have no clusters and no near strangers.

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include <lcmslam/features/descriptor_search.hpp>
#include <lcmslam/surf/surf.hpp>

namespace lcmslam {

/// At most `budget` features of every `step`-th image of a folder; empty without the folder.
inline std::vector<std::vector<Feature>> recorded_features(const std::filesystem::path& images,
                                                           std::size_t step, int budget = 1000) {
  std::vector<std::string> files;
  if (std::filesystem::exists(images))
    for (const auto& entry : std::filesystem::directory_iterator(images)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  SurfSettings settings;
  settings.hessian_threshold = 5;  // the budget decides
  settings.budget.max_features = budget;
  Surf surf(settings);
  std::vector<std::vector<Feature>> frames;
  for (std::size_t i = 0; i < files.size(); i += step) {
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
    surf.detectAndCompute(cv::imread(files[i], cv::IMREAD_GRAYSCALE), cv::noArray(), keypoints, descriptors);
    auto& features = frames.emplace_back(keypoints.size());
    for (std::size_t k = 0; k < keypoints.size(); ++k) {
      features[k].x = keypoints[k].pt.x;
      features[k].y = keypoints[k].pt.y;
      features[k].laplacian = static_cast<std::int8_t>(keypoints[k].class_id);
      features[k].descriptor = to_bytes(descriptors.ptr<float>(static_cast<int>(k)));
    }
  }
  return frames;
}

/// Every other frame's features, from the first on: those that match a landmark (mutual, ratio 0.8) bring
/// its newest descriptor, the others are new landmarks, until there are `limit`.
inline std::vector<Feature> merged_map(const std::vector<std::vector<Feature>>& frames, std::size_t limit) {
  std::vector<Feature> map;
  Matcher matcher;
  for (std::size_t i = 0; i < frames.size(); i += 2) {
    std::vector<bool> known(frames[i].size(), false);
    for (const Match& m : matcher.match(frames[i], map)) {
      known[static_cast<std::size_t>(m.a)] = true;
      map[static_cast<std::size_t>(m.b)].descriptor = frames[i][static_cast<std::size_t>(m.a)].descriptor;
    }
    for (std::size_t k = 0; k < frames[i].size() && map.size() < limit; ++k)
      if (!known[k]) map.push_back(frames[i][k]);
  }
  return map;
}

/// `count` features of each frame that the map has not seen.
inline std::vector<std::vector<Feature>> unseen_queries(const std::vector<std::vector<Feature>>& frames,
                                                        std::size_t every, std::size_t count) {
  std::vector<std::vector<Feature>> queries;
  for (std::size_t i = 1; i < frames.size(); i += 2 * every)
    queries.emplace_back(frames[i].begin(),
                         frames[i].begin() + static_cast<std::ptrdiff_t>(std::min(count, frames[i].size())));
  return queries;
}

/// Share of queries whose nearest and second nearest are as near as the exact ones.
struct Recall {
  std::size_t queries = 0, both = 0, nearest = 0;
  void add(const std::vector<Neighbours>& found, const std::vector<Neighbours>& exact) {
    for (std::size_t i = 0; i < exact.size(); ++i) {
      ++queries;
      const bool first = found[i][0].distance2 == exact[i][0].distance2;
      nearest += first;
      both += first && found[i][1].distance2 == exact[i][1].distance2;
    }
  }
  double of_both() const { return static_cast<double>(both) / static_cast<double>(queries); }
  double of_nearest() const { return static_cast<double>(nearest) / static_cast<double>(queries); }
};

}  // namespace lcmslam
