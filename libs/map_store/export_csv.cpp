#include <iomanip>
#include <sstream>

#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/map_store/map_export.hpp>

namespace lcmslam {

void save_csv(const FilePlace& file, const std::vector<Landmark>& landmarks) {
  std::ostringstream text;
  text << "id,x,y,z,cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz,observations,log_odds,red,green,blue\n"
       << std::setprecision(7);
  for (const Landmark& l : landmarks) {
    const Eigen::Matrix3d& S = l.covariance;
    text << l.id;
    for (const double number :
         {l.mean.x(), l.mean.y(), l.mean.z(), S(0, 0), S(0, 1), S(0, 2), S(1, 1), S(1, 2), S(2, 2)})
      text << "," << number;
    text << "," << l.observations << "," << l.log_odds;
    for (const int channel : l.colour) text << "," << channel;
    text << "\n";
  }
  write_atomically(file, text.str());
}

}  // namespace lcmslam
