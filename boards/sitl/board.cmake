# The world that flies beside the graph, or the link to another one.
target_link_libraries(${target} PRIVATE stator_world stator_hil)
