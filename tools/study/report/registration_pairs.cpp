#include "tools/study/report/registration_pairs.hpp"

#include <fmt/format.h>
#include <cmath>

#include <lcmslam/configuration/share.hpp>
#include <lcmslam/dense_mapper/thesis/alternating.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/simulation/simulation.hpp>

namespace lcmslam {
namespace {

constexpr double degrees = 180 / M_PI;

std::vector<RegistrationPair> rendered(const PairChoice& choice) {
  SimulationSettings settings;
  settings.scene = share_path("config/scenes/" + choice.scene + ".yaml");
  settings.seed = static_cast<std::uint64_t>(choice.seed);
  const Simulation simulation(settings);
  const RgbdCalibration& calibration = simulation.calibration();
  const DepthRegistration registration(calibration);
  Surf surf;
  const auto view = [&](Utime utime) {
    return make_pair_view(simulation.render(utime), registration, choice.voxel_size, surf);
  };
  const auto camera = [&](const PairView& seen) {
    return simulation.T_world_robot(seen.depth_utime) * calibration.T_robot_camera;
  };
  const auto apart = static_cast<Utime>(1e6 * choice.apart);
  const Utime first = simulation.start() + 1'500'000;  // it stands still at first
  // Of three times as many places as are needed, those in an order that covers the path however many are left
  // out.
  const int places = 3 * choice.pairs;
  const Utime step = (simulation.end() - apart - first) / std::max(1, places);
  std::vector<RegistrationPair> pairs;
  for (int i = 0; i < places && static_cast<int>(pairs.size()) < choice.pairs; ++i) {
    const int place = (i % choice.pairs) * 3 + i / choice.pairs;
    RegistrationPair pair;
    pair.scene = choice.scene;
    pair.apart = choice.apart;
    pair.target = view(first + place * step);
    pair.source = view(first + place * step + apart);
    pair.T_target_source = camera(pair.target).inverse() * camera(pair.source);
    pair.overlap = pair_overlap(pair.source, pair.target, pair.T_target_source, 2 * choice.voxel_size);
    if (pair.overlap >= choice.min_overlap) pairs.push_back(std::move(pair));
  }
  return pairs;
}

}  // namespace

const std::vector<RegistrationPair>& PairStore::pairs(const PairChoice& choice) {
  const std::string key = fmt::format("{} {} {} {} {} {}", choice.scene, choice.seed, choice.pairs,
                                      choice.apart, choice.voxel_size, choice.min_overlap);
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const auto& [name, pairs] : kept_)
    if (name == key) return *pairs;
  kept_.emplace_back(key, std::make_unique<std::vector<RegistrationPair>>(rendered(choice)));
  return *kept_.back().second;
}

PairError error_of(const RegistrationPair& pair, const Eigen::Isometry3d& T_target_source) {
  const Eigen::Isometry3d error = pair.T_target_source.inverse() * T_target_source;
  return {error.translation().norm(), degrees * rotation_angle(error)};
}

Eigen::Isometry3d start_beside(const RegistrationPair& pair, double translation, double rotation,
                               int number) {
  Random random(static_cast<std::uint64_t>(number), 0x0ff5e7);
  const auto direction = [&] {
    return Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
  };
  const Eigen::Vector3d shift = translation * direction();
  const Eigen::AngleAxisd turn(rotation / degrees, direction());
  // Turned about the middle of the scene rather than about the camera, so that both offsets are told apart.
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& p : pair.source.cloud.points) middle += p.cast<double>();
  middle /= std::max<double>(1, static_cast<double>(pair.source.cloud.size()));
  return pair.T_target_source * Eigen::Translation3d(middle + shift) * turn * Eigen::Translation3d(-middle);
}

RegistrationSettings thesis_icp(SolverKind solver) {
  RegistrationSettings settings = AlternatingSettings().registration;
  settings.solver = solver;
  settings.max_iterations = 100;
  settings.epsilon_rms = 1e-5;
  settings.epsilon_translation = settings.epsilon_rotation = 0;
  return settings;
}

ChartSeries cloud_from_above(const std::string& name, const Cloud& cloud, const Eigen::Isometry3d& T) {
  constexpr std::size_t most = 500;
  ChartSeries series;
  series.name = name;
  series.mark = ChartSeries::Mark::dots;
  const std::size_t step = 1 + cloud.size() / most;
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    const Eigen::Vector3d p = T * cloud.points[i].cast<double>();
    series.x.push_back(p.x());
    series.y.push_back(p.z());
  }
  return series;
}

}  // namespace lcmslam
