# Tests of C++: stator_add_test, and the tests of a project outside this repository.
find_package(GTest REQUIRED)
include(GoogleTest)

# For tests that call nodes and topics without a graph; a test with a graph takes nothing of it.
add_library(stator_no_graph STATIC "${CMAKE_SOURCE_DIR}/tests/no_graph.cpp")
target_link_libraries(stator_no_graph PRIVATE stator_core stator_virtual stator_flags)
add_library(stator_without_graph INTERFACE)
target_link_libraries(stator_without_graph INTERFACE stator_core stator_testing stator_virtual
    $<LINK_GROUP:RESCAN,stator_no_graph,stator_virtual>)

# stator_add_test(NAME SOURCES... LIBRARIES ...): one executable, each of its cases a test of CTest.
function(stator_add_test name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "LONG" "" "SOURCES;LIBRARIES")
    add_executable(${name} ${arg_SOURCES})
    target_link_libraries(${name} PRIVATE
        ${arg_LIBRARIES} stator_without_graph stator_flags GTest::gtest_main)
    stator_precompile(${name} TEST)
    if(arg_LONG)
        gtest_discover_tests(${name} PROPERTIES LABELS long TIMEOUT 3000)
    else()
        gtest_discover_tests(${name} PROPERTIES TIMEOUT 600)
    endif()
endfunction()

# stator_add_project_tests(PROJECT): PROJECT/tests/apps/NAME/*_test.cpp are tests of app NAME, and
# PROJECT/tests/graphs/NAME/*_test.cpp of graph NAME.yaml in the simulated world.
function(stator_add_project_tests project)
    add_custom_target(all_tests)
    file(GLOB tests RELATIVE "${project}/tests/apps" CONFIGURE_DEPENDS "${project}/tests/apps/*/*_test.cpp")
    set(apps)
    foreach(test IN LISTS tests)
        get_filename_component(app "${test}" DIRECTORY)
        list(APPEND apps ${app})
    endforeach()
    list(REMOVE_DUPLICATES apps)
    if(apps)
        stator_add_apps(app "${project}" "${apps}")
    endif()
    foreach(test IN LISTS tests)
        get_filename_component(app "${test}" DIRECTORY)
        get_filename_component(name "${test}" NAME_WE)
        stator_add_test(${app}.${name} SOURCES "${project}/tests/apps/${test}" LIBRARIES app_${app})
        add_dependencies(${app}.${name} app_rules)
        add_dependencies(all_tests ${app}.${name})
    endforeach()

    file(GLOB tests RELATIVE "${project}/tests/graphs" CONFIGURE_DEPENDS "${project}/tests/graphs/*/*_test.cpp")
    foreach(test IN LISTS tests)
        get_filename_component(graph "${test}" DIRECTORY)
        get_filename_component(name "${test}" NAME_WE)
        if(NOT TARGET graph_${graph}_generated)
            stator_add_graph_parts(graph_${graph} "${project}/${graph}.yaml" sitl)
        endif()
        set(program ${graph}.${name})
        add_executable(${program} "${project}/tests/graphs/${test}"
            "${CMAKE_SOURCE_DIR}/boards/sitl/board.cpp" "${CMAKE_SOURCE_DIR}/boards/sitl/links_of_flight.cpp"
            "${CMAKE_SOURCE_DIR}/boards/sitl/outside.cpp")
        target_include_directories(${program} PRIVATE "${CMAKE_SOURCE_DIR}/boards/sitl" "${CMAKE_SOURCE_DIR}/tests/project")
        target_link_libraries(${program} PRIVATE graph_${graph}_generated stator_world stator_hil GTest::gtest_main)
        stator_precompile(${program} TEST)
        gtest_discover_tests(${program} PROPERTIES TIMEOUT 600)
        add_dependencies(all_tests ${program})
    endforeach()
endfunction()
