# What `cmake --install` puts where. Components: runtime (programs, what they read, and python/), development (libraries,
# headers, the CMake package), spy (the plug-ins of lcm-spy). Users find each library of libs/ as lcmslam::surf and so
# on: find_package(lcmslam COMPONENTS surf).
include(CMakePackageConfigHelpers)
set(LCMSLAM_CMAKE_FOLDER ${CMAKE_INSTALL_LIBDIR}/cmake/lcmslam)

# Programs look for their data in ../share/lcmslam beside their own folder, in the build tree as after install.
set(LCMSLAM_SHARE ${CMAKE_BINARY_DIR}/share/lcmslam)
file(MAKE_DIRECTORY ${LCMSLAM_SHARE})
foreach(folder config logs python lcmtypes)
  file(CREATE_LINK ${CMAKE_SOURCE_DIR}/${folder} ${LCMSLAM_SHARE}/${folder} SYMBOLIC)
  install(DIRECTORY ${folder} DESTINATION ${CMAKE_INSTALL_DATADIR}/lcmslam COMPONENT runtime
          PATTERN __pycache__ EXCLUDE PATTERN CMakeLists.txt EXCLUDE)
endforeach()
file(CREATE_LINK ${CMAKE_SOURCE_DIR}/libs/web/page/dist ${LCMSLAM_SHARE}/page SYMBOLIC)
install(DIRECTORY libs/web/page/dist/ DESTINATION ${CMAKE_INSTALL_DATADIR}/lcmslam/page COMPONENT runtime)
file(CREATE_LINK ${CMAKE_SOURCE_DIR}/tools/study/report/page/dist ${LCMSLAM_SHARE}/study SYMBOLIC)
install(DIRECTORY tools/study/report/page/dist/ DESTINATION ${CMAKE_INSTALL_DATADIR}/lcmslam/study COMPONENT runtime)

# lcmslam_install_library(surf LINKS lcmslam_parallel opencv_core ...): of the folder of libs/ that calls it.
function(lcmslam_install_library name)
  cmake_parse_arguments(ARG "" "" "LINKS" ${ARGN})
  set_target_properties(lcmslam_${name} PROPERTIES EXPORT_NAME ${name})
  add_library(lcmslam::${name} ALIAS lcmslam_${name})
  install(TARGETS lcmslam_${name} EXPORT lcmslamTargets ARCHIVE COMPONENT development)
  file(RELATIVE_PATH room ${CMAKE_SOURCE_DIR}/libs ${CMAKE_CURRENT_SOURCE_DIR})
  if(NOT room MATCHES "^\\.\\.")
    install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/lcmslam/${room}
            COMPONENT development FILES_MATCHING PATTERN *.hpp PATTERN page EXCLUDE)
  endif()
  list(REMOVE_DUPLICATES ARG_LINKS)
  set_property(GLOBAL APPEND PROPERTY LCMSLAM_INSTALLED ${name})
  set_property(GLOBAL PROPERTY LCMSLAM_LINKS_${name} ${ARG_LINKS})
endfunction()

# Whether lcmslam_NAME is to be built: all, unless LCMSLAM_COMPONENTS names some; those and what they link.
function(lcmslam_is_needed name variable)
  set(needed ON)
  if(LCMSLAM_COMPONENTS AND NOT name IN_LIST LCMSLAM_COMPONENTS)
    set(needed OFF)
    get_property(others GLOBAL PROPERTY LCMSLAM_INSTALLED)
    foreach(other ${others})
      get_property(links GLOBAL PROPERTY LCMSLAM_LINKS_${other})
      if(lcmslam_${name} IN_LIST links)
        set(needed ON)
      endif()
    endforeach()
  endif()
  set(${variable} ${needed} PARENT_SCOPE)
endfunction()

# Writes and installs lcmslamConfig.cmake for the libraries so far.
function(lcmslam_install_package)
  get_property(LCMSLAM_INSTALLED GLOBAL PROPERTY LCMSLAM_INSTALLED)
  list(SORT LCMSLAM_INSTALLED)
  set(LCMSLAM_LINKS "")
  foreach(name ${LCMSLAM_INSTALLED})
    get_property(links GLOBAL PROPERTY LCMSLAM_LINKS_${name})
    list(JOIN links " " links)
    string(APPEND LCMSLAM_LINKS "set(lcmslam_${name}_links ${links})\n")
  endforeach()
  set(folder ${CMAKE_BINARY_DIR}/package)
  configure_package_config_file(${CMAKE_SOURCE_DIR}/cmake/lcmslamConfig.cmake.in ${folder}/lcmslamConfig.cmake
                                INSTALL_DESTINATION ${LCMSLAM_CMAKE_FOLDER} NO_SET_AND_CHECK_MACRO)
  write_basic_package_version_file(${folder}/lcmslamConfigVersion.cmake COMPATIBILITY SameMinorVersion)
  install(EXPORT lcmslamTargets NAMESPACE lcmslam:: DESTINATION ${LCMSLAM_CMAKE_FOLDER} COMPONENT development)
  install(FILES ${folder}/lcmslamConfig.cmake ${folder}/lcmslamConfigVersion.cmake cmake/LcmSlamPackages.cmake
                cmake/Findlcm.cmake cmake/Findlibdeflate.cmake cmake/Findlz4.cmake cmake/Findoctomap.cmake
                cmake/Findsodium.cmake cmake/Findzstd.cmake
          DESTINATION ${LCMSLAM_CMAKE_FOLDER} COMPONENT development)
endfunction()
