# Variables and functions that the tests of this folder share.
cmake_minimum_required(VERSION 3.24)

# Packages of which a part must do without what is not its own.
set(all_packages Eigen3 Ceres PCL embree lcm yaml-cpp spdlog CLI11 nlohmann_json libjpeg-turbo libdeflate SQLite3 GTest benchmark)

# hide_all_but(VARIABLE PACKAGE...): options for a configure run in which the others are not there.
function(hide_all_but variable)
  set(options "")
  foreach(package ${all_packages})
    if(NOT package IN_LIST ARGN)
      list(APPEND options -DCMAKE_DISABLE_FIND_PACKAGE_${package}=ON)
    endif()
  endforeach()
  set(${variable} ${options} PARENT_SCOPE)
endfunction()

# run(COMMAND...): fails with its output.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}: ${result}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()
