# Installed programs know their version, find their data beside themselves and hold no path of the source.
include(${CMAKE_CURRENT_LIST_DIR}/packages.cmake)
file(REMOVE_RECURSE ${FOLDER})
file(MAKE_DIRECTORY ${FOLDER})
set(bridge "")
if(EXISTS ${PREFIX}/bin/lcmslam-bridge)  # built where libmosquitto is there
  set(bridge -bridge)
endif()
foreach(name ${bridge} "" -tools -study -camera -surf -odometry -fastslam -icp -map-server)
  run(${PREFIX}/bin/lcmslam${name} --version)
  if(NOT output STREQUAL "lcmslam ${VERSION}\n")
    message(FATAL_ERROR "lcmslam${name} --version says ${output}")
  endif()
  file(STRINGS ${PREFIX}/bin/lcmslam${name} lines REGEX "${SOURCE}/")
  if(lines AND BUILD_TYPE STREQUAL "Release")
    message(FATAL_ERROR "lcmslam${name} holds ${lines}")
  endif()
endforeach()

# Help of what the first program does itself, and of what it hands over.
foreach(command doctor evaluate "log cut" study)
  separate_arguments(words UNIX_COMMAND "${command}")
  run(${PREFIX}/bin/lcmslam help ${words})
  if(NOT output MATCHES "Usage: lcmslam ${command} ")
    message(FATAL_ERROR "lcmslam help ${command} says ${output}")
  endif()
endforeach()

# Takes share/lcmslam/config/replay.yaml, which nobody names.
file(COPY ${PREFIX}/share/lcmslam/logs/kitchen.lcmlog DESTINATION ${FOLDER})
execute_process(COMMAND ${PREFIX}/bin/lcmslam study --only filter kitchen.lcmlog --seeds 1 WORKING_DIRECTORY ${FOLDER}
                RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "lcmslam study: ${output}")
endif()
file(GLOB report ${FOLDER}/out/*/report.json)
file(READ ${report} json)
string(JSON version GET ${json} version)
if(NOT version STREQUAL VERSION)
  message(FATAL_ERROR "report.json is of version ${version}")
endif()

# LCMSLAM_SHARE has the word over it.
execute_process(COMMAND ${CMAKE_COMMAND} -E env LCMSLAM_SHARE=/nowhere ${PREFIX}/bin/lcmslam demo --headless
                WORKING_DIRECTORY ${FOLDER} RESULT_VARIABLE result ERROR_VARIABLE output)
string(FIND "${output}" "/nowhere/config/demo.yaml: is not there; LCMSLAM_SHARE names the folder" position)
if(result EQUAL 0 OR position EQUAL -1)
  message(FATAL_ERROR "without its data, lcmslam demo says: ${output}")
endif()
