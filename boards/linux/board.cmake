# The world that flies beside the graph.
target_link_libraries(${target} PRIVATE stator_world)
