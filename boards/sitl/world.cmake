# The sources of the simulated world, which knows no graph and no device.
set(world_sources battery.cpp can_parts.cpp earth.cpp faults.cpp flight_facts.cpp flight_watch.cpp ground.cpp
    navigation_sensors.cpp noise.cpp options.cpp pilot.cpp plant.cpp sensors.cpp truth.cpp variation.cpp wind.cpp
    world.cpp)
list(TRANSFORM world_sources PREPEND "${CMAKE_SOURCE_DIR}/boards/sitl/")
