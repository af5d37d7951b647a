#pragma once
// Maps as files that MeshLab, CloudCompare, Open3D and PCL read.
//
// Every function that saves writes atomically (files/atomic_file.hpp) and throws std::runtime_error that
// names the file and the reason. Empty maps give valid files without points.

#include <string>
#include <vector>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/files/part_file.hpp>
#include <lcmslam/map_store/landmark_map.hpp>

namespace lcmslam {

/// Binary little-endian PLY: x y z [nx ny nz] red green blue; normals when the cloud has them (0 0 0
/// where unknown).
void save_ply(const FilePlace& file, const ColouredCloud& cloud);
/// The bytes of such a file, for those who send it.
std::string cloud_ply(const ColouredCloud& cloud);

/// PCL's binary PCD: x y z rgb, or x y z rgb normal_x normal_y normal_z curvature with normals (NaN
/// where unknown, curvature 0).
void save_pcd(const FilePlace& file, const ColouredCloud& cloud);

/// x y z red green blue id observations and the upper triangle of the covariance (m^2) as cov_xx cov_xy
/// cov_xz cov_yy cov_yz cov_zz. `id` is an int, or a double when one of them needs more than 32 bits.
void save_ply(const FilePlace& file, const std::vector<Landmark>& landmarks);

/// x y z rgb label; label is the id modulo 2^32 (PCD has no wider whole numbers in PCL).
void save_pcd(const FilePlace& file, const std::vector<Landmark>& landmarks);

/// A line a landmark below one that names the columns: id,x,y,z,cov_xx,...,cov_zz,observations,log_odds,
/// red,green,blue (m, m^2).
void save_csv(const FilePlace& file, const std::vector<Landmark>& landmarks);

/// Points, colours and normals (empty when the file has none) through PCL. Throw std::runtime_error
/// when the file is missing or is not such a file.
ColouredCloud load_ply(const std::filesystem::path& file);
ColouredCloud load_pcd(const std::filesystem::path& file);

}  // namespace lcmslam
