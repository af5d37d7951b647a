#pragma once
// The truth and the estimates that `evaluate` compares, converted to the same body frame.

#include <string>
#include <vector>

#include <lcmslam/evaluation/trajectory.hpp>

namespace lcmslam {

struct EvaluatedPath {
  std::string name;     ///< short, for tables
  std::string file;     ///< where it comes from
  std::string channel;  ///< of a log, else empty
  std::string body;     ///< frame whose pose it is; empty: the file does not say
  Trajectory trajectory;
  int lost = 0, degraded = 0;  ///< poses with that status
  /// How it is known that it was made from ground truth; empty when it was not, as far as can be known.
  std::string truth_origin;
};

struct InputRequest {
  std::string truth;                   ///< FILE or LOG:CHANNEL; empty: the log's own
  std::vector<std::string> estimates;  ///< the same; a log alone stands for its default channels
  std::string truth_body;              ///< overrides what is known: "robot" or "camera"
  std::string estimate_body;
  std::string
      calibration;  ///< log or YAML that says where the camera sits on the robot; empty: a log that is read
};

struct EvaluationInputs {
  EvaluatedPath truth;
  std::vector<EvaluatedPath> estimates;
  std::vector<std::string> notes;  ///< what was converted, assumed and left out
};

/// FILE.lcmlog:CHANNEL; what exists as it is written is a file.
struct FileChannel {
  std::string file, channel;
};
FileChannel split_channel(const std::string& text);

/// Reads text files (pose_text.hpp) and logs and converts what speaks of the camera where others speak of the
/// robot. Throws TrajectoryError or std::runtime_error naming the file, and the line or the channel.
EvaluationInputs read_inputs(const InputRequest& request);

}  // namespace lcmslam
