// Any text as a TUM trajectory: what is read is sorted, finite and rigid, and is written and read again
// with the same stamps.

#include <cstdlib>
#include <sstream>

#include <lcmslam/evaluation/trajectory_error.hpp>

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcmslam;
  std::istringstream text(std::string(reinterpret_cast<const char*>(data), size));
  Trajectory trajectory;
  try {
    trajectory = read_tum(text, "fuzzed");
  } catch (const TrajectoryError&) {
    return 0;
  }
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    const Eigen::Isometry3d& T = trajectory[i].T_world_body;
    require(T.matrix().allFinite());
    require((T.linear() * T.linear().transpose()).isApprox(Eigen::Matrix3d::Identity(), 1e-9));
    require(i == 0 || trajectory[i].utime > trajectory[i - 1].utime);
  }
  std::stringstream written;
  write_tum(written, trajectory);
  const Trajectory again = read_tum(written, "written");
  require(again.size() == trajectory.size());
  for (std::size_t i = 0; i < again.size(); ++i) require(again[i].utime == trajectory[i].utime);
  if (trajectory.size() >= 3) {  // fewer fit any alignment: refused
    const TrajectoryReport report = evaluate(trajectory, again);
    require(report.matched_poses == trajectory.size());
    require(std::isfinite(report.absolute.translation.rmse));
  }
  return 0;
}
