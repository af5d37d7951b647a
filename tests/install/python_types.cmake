# lcm-gen's Python package of the message types imports, and a message comes back from its bytes. No package of LCM is
# needed for that.
include(${CMAKE_CURRENT_LIST_DIR}/packages.cmake)
find_program(lcm_gen lcm-gen)
find_program(python NAMES python3)
if(NOT lcm_gen OR NOT python)
  message(STATUS "skipped: there is no lcm-gen or no python3 here")
  return()
endif()
file(REMOVE_RECURSE ${FOLDER})
file(GLOB types ${SOURCE}/lcmtypes/*.lcm)
run(${lcm_gen} --python --ppath ${FOLDER} ${types})
file(WRITE ${FOLDER}/use_types.py "import lcmslam
graph = lcmslam.graph_t()
graph.frame, graph.n_edges, graph.edges = 'map', 1, [lcmslam.graph_edge_t()]
graph.edges[0].T_from_to = lcmslam.rigid_transform_t()
graph.edges[0].to_node = 7
back = lcmslam.graph_t.decode(graph.encode())
assert back.frame == 'map' and back.edges[0].to_node == 7
")
run(${CMAKE_COMMAND} -E env PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=${FOLDER} ${python} ${FOLDER}/use_types.py)
