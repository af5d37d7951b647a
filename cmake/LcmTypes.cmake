# lcm_types(TARGET types PACKAGE pkg FILES a_t.lcm ...): runs lcm-gen once for C++ into an INTERFACE
# target of SYSTEM headers (generated code does not meet our warnings), and, where Java is there,
# makes share/lcmslam/java/TARGET.jar for lcm-spy.
function(lcm_types)
  find_program(LCM_GEN lcm-gen REQUIRED)
  cmake_parse_arguments(ARG "" "TARGET;PACKAGE" "FILES" ${ARGN})
  set(out ${CMAKE_CURRENT_BINARY_DIR}/cpp)
  set(java ${CMAKE_CURRENT_BINARY_DIR}/java)
  set(headers)
  set(java_sources)
  foreach(file ${ARG_FILES})
    get_filename_component(type ${file} NAME_WE)
    list(APPEND headers ${out}/${ARG_PACKAGE}/${type}.hpp)
    list(APPEND java_sources ${java}/src/${ARG_PACKAGE}/${type}.java)
  endforeach()
  add_custom_command(
    OUTPUT ${headers}
    COMMAND ${LCM_GEN} --cpp --cpp-std c++11 --cpp-hpath ${out} ${ARG_FILES}
    DEPENDS ${ARG_FILES}
    COMMENT "lcm-gen: C++ types"
    VERBATIM)
  add_custom_target(${ARG_TARGET}_headers DEPENDS ${headers})
  add_library(${ARG_TARGET} INTERFACE)
  add_dependencies(${ARG_TARGET} ${ARG_TARGET}_headers)
  target_include_directories(${ARG_TARGET} SYSTEM INTERFACE $<BUILD_INTERFACE:${out}>
                                                            $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${ARG_TARGET} INTERFACE lcm::lcm)
  install(FILES ${headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${ARG_PACKAGE} COMPONENT development)

  find_program(JAVAC javac)
  find_program(JAR jar)
  find_file(LCM_JAR lcm.jar PATHS /usr/share/java /usr/local/share/java NO_DEFAULT_PATH)
  if(JAVAC AND JAR AND LCM_JAR)
    set(jar ${LCMSLAM_SHARE}/java/${ARG_TARGET}.jar)
    add_custom_command(
      OUTPUT ${jar}
      COMMAND ${CMAKE_COMMAND} -E rm -rf ${java}
      COMMAND ${LCM_GEN} --java --jpath ${java}/src ${ARG_FILES}
      COMMAND ${CMAKE_COMMAND} -E make_directory ${java}/classes
      COMMAND ${JAVAC} -nowarn -cp ${LCM_JAR} -d ${java}/classes ${java_sources}
      COMMAND ${CMAKE_COMMAND} -E make_directory ${LCMSLAM_SHARE}/java
      COMMAND ${JAR} cf ${jar} -C ${java}/classes .
      DEPENDS ${ARG_FILES}
      COMMENT "lcm-gen: Java types"
      VERBATIM)
    add_custom_target(${ARG_TARGET}_jar ALL DEPENDS ${jar})
    install(FILES ${jar} DESTINATION ${CMAKE_INSTALL_DATADIR}/lcmslam/java COMPONENT spy)
  endif()
endfunction()
