#pragma once
// Pairs that are wrong are left out before the solver sees them.

#include <memory>

#include "icp/pair.hpp"
#include "icp/registration_settings.hpp"

namespace lcmslam {

class Rejector {
 public:
  virtual ~Rejector() = default;
  /// Erases pairs, keeping the order of the others.
  virtual void reject(std::vector<Pair>& pairs) const = 0;
};

/// Normals that differ by more than an angle (Pulli 1999); unknown normals pass.
class NormalAngleRejector : public Rejector {
 public:
  explicit NormalAngleRejector(double max_angle);
  void reject(std::vector<Pair>& pairs) const override;

 private:
  double min_cosine_;
};

/// Keeps the nearest fraction (Chetverikov 2002, trimmed ICP).
class TrimmedRejector : public Rejector {
 public:
  explicit TrimmedRejector(double kept_fraction) : kept_fraction_(kept_fraction) {}
  void reject(std::vector<Pair>& pairs) const override;

 private:
  double kept_fraction_;
};

/// Without the target's normal there is no plane.
class MissingNormalRejector : public Rejector {
 public:
  void reject(std::vector<Pair>& pairs) const override;
};

/// The chain that the settings ask for.
std::vector<std::unique_ptr<Rejector>> make_rejectors(const RegistrationSettings& settings);

}  // namespace lcmslam
