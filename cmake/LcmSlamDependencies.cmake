# Everything comes from Debian 12's packages (tools/packages.txt).
list(PREPEND CMAKE_MODULE_PATH ${CMAKE_CURRENT_LIST_DIR})
include(LcmSlamPackages)

# lcmslam_require(ITEM...): the packages that bring them, or an error that names the missing.
function(lcmslam_require)
  lcmslam_find(missing ${ARGN})
  if(missing)
    message(FATAL_ERROR "lcmslam: not found: ${missing}. On Debian 12, ./lcmslam build installs what is missing "
                        "(tools/packages.txt).")
  endif()
endfunction()

lcmslam_require(Eigen3::Eigen opencv_core)  # the precompiled headers'
if(NOT LCMSLAM_COMPONENTS)  # the programs and the tests; what the libraries link they ask for themselves
  lcmslam_require(CLI11::CLI11 nlohmann_json::nlohmann_json GTest::gmock benchmark::benchmark assimp::assimp opencv_calib3d
                  opencv_flann opencv_rgbd pcl_common pcl_io pcl_search pcl_registration)
endif()
