#pragma once
// A kept map on the page's board.

#include <nlohmann/json.hpp>

#include <lcmslam/live_map/answer.hpp>
#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/web/board.hpp>

namespace lcmslam {

class KeptPage {
 public:
  /// Shows what is in the file on the board: the sessions that lie in its map; where `sessions` has names
  /// (names_of), those alone. Throws StoreError where something cannot be read, std::runtime_error where
  /// nothing is there to be shown.
  /// `can`: what the page may ask for.
  KeptPage(const std::filesystem::path& file, const std::vector<std::string>& sessions,
           const nlohmann::json& can, Board& board);

  /// What a question looks at. Throws std::runtime_error in words for who asked.
  AskedMap asked_map(const Question& question) const;

 private:
  std::string name_;
  DenseMap dense_;  // of all sessions, in the map's frame
  std::vector<Landmark> landmarks_;
  std::shared_ptr<const LiveMap> layers_;
  std::string no_layers_;  // why there are none
  std::optional<Eigen::Isometry3d> T_map_robot_;
};

}  // namespace lcmslam
