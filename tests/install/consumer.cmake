# tests/consumer against the prefix: each part with only its own packages to be found. OpenCV is everybody's.
include(${CMAKE_CURRENT_LIST_DIR}/packages.cmake)
file(REMOVE_RECURSE ${FOLDER})
set(surf_packages "")
set(registration_packages Eigen3 flann lz4)
set(fastslam_packages Eigen3 Ceres)
foreach(part surf registration fastslam)
  hide_all_but(hidden ${${part}_packages})
  run(${CMAKE_COMMAND} -S ${SOURCE}/tests/consumer -B ${FOLDER}/${part} -DPARTS=${part} -DCMAKE_PREFIX_PATH=${PREFIX}
      -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS=-Werror=all ${hidden})
  file(STRINGS ${FOLDER}/${part}/CMakeCache.txt found REGEX "^lcmslam_DIR:PATH=${PREFIX}/")
  if(NOT found)
    message(FATAL_ERROR "another lcmslam than ${PREFIX}'s was found")
  endif()
  run(${CMAKE_COMMAND} --build ${FOLDER}/${part})
  run(${CMAKE_CTEST_COMMAND} --test-dir ${FOLDER}/${part} --output-on-failure --no-tests=error)
endforeach()

# What is missing is named.
hide_all_but(hidden Eigen3)
execute_process(COMMAND ${CMAKE_COMMAND} -S ${SOURCE}/tests/consumer -B ${FOLDER}/without_ceres "-DPARTS=fastslam;walls"
                        -DCMAKE_PREFIX_PATH=${PREFIX} ${hidden}
                RESULT_VARIABLE result ERROR_VARIABLE output OUTPUT_QUIET)
string(REGEX REPLACE "[ \n]+" " " output "${output}")
foreach(words "Component fastslam needs Ceres" "There is no component 'walls'; there are bridge;calibration;calibration_self;cameras;cloud;")
  string(FIND "${output}" "${words}" position)
  if(result EQUAL 0 OR position EQUAL -1)
    message(FATAL_ERROR "'${words}' is not said:\n${output}")
  endif()
endforeach()

# Our warnings are no business of users, nor is where we were built.
file(GLOB_RECURSE files ${PREFIX}/lib*/lcmslam*.cmake)
foreach(file ${files})
  file(STRINGS ${file} lines REGEX "-W(all|error|conversion)|${SOURCE}|${BUILD}/include")
  if(lines)
    message(FATAL_ERROR "${file} exports ${lines}")
  endif()
endforeach()
