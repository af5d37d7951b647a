#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/files/decimal_text.hpp>
#include <lcmslam/map_store/map_export.hpp>

namespace lcmslam {

void save_csv(const FilePlace& file, const std::vector<Landmark>& landmarks) {
  std::string text =
      "id,x,y,z,cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz,observations,log_odds,red,green,blue\n";
  for (const Landmark& l : landmarks) {
    const Eigen::Matrix3d& S = l.covariance;
    text += std::to_string(l.id);
    for (const double number :
         {l.mean.x(), l.mean.y(), l.mean.z(), S(0, 0), S(0, 1), S(0, 2), S(1, 1), S(1, 2), S(2, 2)})
      append_general(text += ',', number, 7);
    text += ',' + std::to_string(l.observations);
    append_general(text += ',', l.log_odds, 7);
    for (const int channel : l.colour) text += ',' + std::to_string(channel);
    text += '\n';
  }
  write_atomically(file, text);
}

}  // namespace lcmslam
