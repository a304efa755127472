# The world that flies beside the graph.
target_link_libraries(${target} PRIVATE sitl_world)
