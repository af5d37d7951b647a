#include <lcmslam/fastslam/particle_set.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/fastslam/pose_space.hpp>
#include <lcmslam/fastslam/resampling.hpp>

namespace lcmslam {
namespace {

constexpr std::uint64_t resampling_stream = 0x726573616d706c65;

Matrix6d scatter(const std::vector<Vector6d>& offsets, const std::vector<double>& weights,
                 const Vector6d& centre) {
  Matrix6d sum = Matrix6d::Zero();
  for (std::size_t k = 0; k < offsets.size(); ++k)
    sum += weights[k] * (offsets[k] - centre) * (offsets[k] - centre).transpose();
  return 0.5 * (sum + sum.transpose());  // exactly symmetric
}

}  // namespace

ParticleSet::ParticleSet(const FastSlamSettings& settings)
    : settings_(settings),
      particles_(static_cast<std::size_t>(settings.particles)),
      resampling_stream_(settings.seed, resampling_stream),
      calibration_(settings) {
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    streams_.emplace_back(settings.seed, i);
    particles_[i].lineage = static_cast<int>(i);
  }
}

std::vector<double> ParticleSet::weights() const {
  std::vector<double> logs;
  for (const Particle& particle : particles_) logs.push_back(particle.log_weight);
  return normalised_weights(logs);
}

std::vector<double> ParticleSet::choose_best() {
  std::vector<double> weights = this->weights();
  best_ = static_cast<int>(std::max_element(weights.begin(), weights.end()) - weights.begin());
  return weights;
}

ParticleSet::Estimate ParticleSet::estimate(const std::vector<double>& weights) const {
  const Eigen::Isometry3d T_best_world = best().T_world_robot.inverse();
  std::vector<Vector6d> offsets(particles_.size());
  Vector6d mean = Vector6d::Zero();
  for (std::size_t k = 0; k < particles_.size(); ++k) {
    offsets[k] = se3_log(T_best_world * particles_[k].T_world_robot);
    mean += weights[k] * offsets[k];
  }
  if (settings_.estimate == PoseEstimate::best) mean.setZero();
  return {best().T_world_robot * se3_exp(mean), scatter(offsets, weights, mean) + undrawn_};
}

Matrix6d ParticleSet::mean_square_from_start(const std::vector<double>& weights,
                                             const Eigen::Isometry3d& T_world_robot) const {
  const Eigen::Isometry3d T_robot_world = T_world_robot.inverse();
  std::vector<Vector6d> offsets;
  for (const Particle& particle : particles_)
    offsets.push_back(se3_log(T_robot_world * particle.T_world_start.inverse() * particle.T_world_robot));
  return scatter(offsets, weights, Vector6d::Zero()) + undrawn_;
}

Eigen::Matrix3d ParticleSet::mean_square_from_start(int slot) const {
  const auto at = static_cast<std::size_t>(slot);
  const Eigen::Vector3d centre = best().map.find(at)->mean;
  const std::vector<double> weights = this->weights();
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < particles_.size(); ++k) {
    const LandmarkGaussian landmark = *particles_[k].map.find(at);
    const Eigen::Vector3d offset = particles_[k].T_world_start.inverse() * landmark.mean - centre;
    sum += weights[k] * (landmark.covariance + offset * offset.transpose());
  }
  return sum;
}

bool ParticleSet::resample_when_due(const std::vector<double>& weights) {
  const double limit = settings_.resample_fraction * settings_.particles;
  const bool due = settings_.resample_fraction >= 1 || effective_sample_size(weights) < limit;
  if (due) resample(weights);
  return due;
}

void ParticleSet::resample(const std::vector<double>& weights) {
  const std::vector<int> ancestors = lcmslam::resample(weights, settings_.resampling, resampling_stream_);
  std::vector<Particle> next(particles_.size());
  std::size_t heaviest = 0;
  for (std::size_t k = 0; k < next.size(); ++k) {
    const auto a = static_cast<std::size_t>(ancestors[k]);
    const bool last_copy = k + 1 == next.size() || ancestors[k + 1] != ancestors[k];
    if (last_copy)
      next[k] = std::move(particles_[a]);  // a map with one owner is changed in place
    else
      next[k] = particles_[a];
    next[k].log_weight = 0;
    if (weights[a] > weights[static_cast<std::size_t>(ancestors[heaviest])]) heaviest = k;
  }
  particles_ = std::move(next);
  best_ = static_cast<int>(heaviest);
}

// Their spread no longer covers what is not known of the past, and their mean wanders off (genetic drift).
bool ParticleSet::coalesced() const {
  std::vector<char> lives(particles_.size(), 0);
  for (const Particle& particle : particles_) lives[static_cast<std::size_t>(particle.lineage)] = 1;
  const auto lineages = static_cast<double>(std::count(lives.begin(), lives.end(), 1));
  return lineages < settings_.rejuvenation_lineages * settings_.particles;
}

void ParticleSet::draw_anew(const std::vector<PathSample>& samples,
                            const CalibrationCovariance& calibration_covariance,
                            const std::function<int(std::int32_t)>& slot_of) {
  calibration_.set_covariance(calibration_covariance);
  for (std::size_t k = 0; k < particles_.size(); ++k) {
    Particle& particle = particles_[k];
    particle.T_world_robot = samples[k].T_world_robot;
    particle.T_world_start = samples[k].T_world_start;
    particle.calibration = samples[k].calibration;
    particle.log_weight = 0;
    particle.lineage = static_cast<int>(k);
    for (const auto& [id, landmark] : samples[k].landmarks)
      if (const int slot = slot_of(id); slot >= 0)
        particle.map.edit(static_cast<std::size_t>(slot)) = landmark;
  }
  start_known_ = true;
  undrawn_.setZero();
  best_ = 0;  // the mode
}

void ParticleSet::deform(const Eigen::Isometry3d& T_world_correction,
                         const std::map<int, Eigen::Vector3d>& placed, const std::vector<int>& carried) {
  for (Particle& particle : particles_) {
    for (const auto& [slot, mean] : placed) particle.map.edit(static_cast<std::size_t>(slot)).mean = mean;
    for (const int slot : carried) {
      CompactLandmark& landmark = particle.map.edit(static_cast<std::size_t>(slot));
      landmark.mean = T_world_correction * landmark.mean;
    }
    particle.T_world_robot = renormalised(T_world_correction * particle.T_world_robot, settings_.planar);
  }
}

}  // namespace lcmslam
