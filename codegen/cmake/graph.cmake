# stator_add_graph(TARGET GRAPH BOARD): the program of a graph. The compiler runs when CMake
# configures, and CMake configures again when a graph, an include, a template or a board changes.
if(NOT STATOR_PYTHON)
    set(STATOR_PYTHON "${CMAKE_SOURCE_DIR}/.venv/bin/python" CACHE FILEPATH "Stator's own Python")
endif()
if(NOT EXISTS "${STATOR_PYTHON}")
    message(FATAL_ERROR "missing Python environment .venv; hint: run ./stator setup")
endif()
file(GLOB_RECURSE stator_compiler CONFIGURE_DEPENDS
    "${CMAKE_SOURCE_DIR}/codegen/stator/*.py" "${CMAKE_SOURCE_DIR}/codegen/stator/emit/templates/*.j2")
set_property(DIRECTORY "${CMAKE_SOURCE_DIR}" APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${stator_compiler})

set(stator_gen_options)
if(STATOR_RECORDING)
    list(APPEND stator_gen_options --record)
elseif(STATOR_REPLAY)
    list(APPEND stator_gen_options --replay)
endif()

# Generates the C++ of a graph, or what tests of apps need, and sets graph_* in the caller
# (codegen/stator/emit/templates/graph.cmake.j2). `source` and what follows: arguments of `stator gen`.
macro(stator_generate folder source)
    execute_process(
        COMMAND "${STATOR_PYTHON}" -I -X utf8 -m stator gen "${source}" -o "${folder}" ${ARGN}
        RESULT_VARIABLE generated OUTPUT_QUIET)
    # Watched even after an error, so that mending the graph is enough.
    set_property(DIRECTORY "${CMAKE_SOURCE_DIR}" APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${source}")
    if(NOT generated EQUAL 0)
        message(FATAL_ERROR "'${source}' has errors; see above")
    endif()
    include("${folder}/graph.cmake")
    set_property(DIRECTORY "${CMAKE_SOURCE_DIR}" APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${graph_inputs})
endmacro()

# What nodes and the board may include and declare is checked before they are compiled: TARGET_walls.
function(stator_add_walls target folder libraries)
    set(arguments)
    foreach(entry IN LISTS libraries)
        string(REGEX MATCH "^[^=]+=([^=]+)=(.*)$" matched "${entry}")
        list(APPEND arguments --node "${CMAKE_MATCH_2}" "${folder}/ports/${CMAKE_MATCH_1}")
    endforeach()
    if(NOT graph_executor STREQUAL "cortex_m")
        list(APPEND arguments --may-print)
    endif()
    if(graph_board)
        list(APPEND arguments --board "${graph_board}")
    endif()
    set(stamp "${CMAKE_BINARY_DIR}/generated/${target}_walls")
    add_custom_command(
        OUTPUT "${stamp}"
        COMMAND "${CMAKE_COMMAND}" -E env "PYTHONPATH=${CMAKE_SOURCE_DIR}/codegen"
                "${STATOR_PYTHON}" -m stator.build.walls ${arguments} --stamp "${stamp}"
        DEPENDS "${CMAKE_SOURCE_DIR}/codegen/stator/build/walls.py" "${CMAKE_SOURCE_DIR}/codegen/stator/build/cpp_scan.py"
        DEPFILE "${stamp}.d"
        COMMENT "Checking what nodes of ${target} include"
        VERBATIM)
    add_custom_target(${target}_walls DEPENDS "${stamp}")
endfunction()

# What the objects of apps call and keep is checked behind their compilation: TARGET_rules. `objects`:
# those of generated code, which contain the nodes of headers. In a replay, ports allocate.
function(stator_add_rules target objects libraries)
    add_custom_target(${target}_rules)
    if(NOT STATOR_WALLS OR STATOR_ODR OR STATOR_SANITIZE OR STATOR_REPLAY OR
       graph_executor STREQUAL "cortex_m")
        return()
    endif()
    set(nodes)
    foreach(entry IN LISTS libraries)
        string(REGEX MATCH "^([^=]+)=([^=]+)=(.*)$" matched "${entry}")
        set(library ${target}_${CMAKE_MATCH_1})
        set(node "${CMAKE_MATCH_3}")
        if(NOT node MATCHES "/apps/[^/]+$")
            continue()
        endif()
        list(APPEND nodes --node "${node}")
        get_target_property(type ${library} TYPE)
        if(type STREQUAL "STATIC_LIBRARY")
            list(APPEND objects "$<TARGET_OBJECTS:${library}>")
        endif()
    endforeach()
    if(NOT nodes OR NOT objects)
        return()
    endif()
    set(stamp "${CMAKE_BINARY_DIR}/generated/${target}_rules_stamp")
    add_custom_command(
        OUTPUT "${stamp}"
        COMMAND "${CMAKE_COMMAND}" -E env "PYTHONPATH=${CMAKE_SOURCE_DIR}/codegen"
                "${STATOR_PYTHON}" -m stator.build.app_rules ${nodes} --stamp "${stamp}" ${objects}
        DEPENDS ${objects} "${CMAKE_SOURCE_DIR}/codegen/stator/build/app_rules.py"
        COMMENT "Checking what nodes of ${target} call"
        COMMAND_EXPAND_LISTS
        VERBATIM)
    add_custom_target(${target}_rules_checked DEPENDS "${stamp}")
    add_dependencies(${target}_rules ${target}_rules_checked)
endfunction()

# A target for each app and driver of what was generated. Sets `libraries` and `ports` in the caller.
function(stator_add_nodes target folder)
    # What all apps and drivers may include: messages, topics, maths, DroneCAN, MAVLink.
    add_library(${target}_interfaces INTERFACE)
    target_include_directories(${target}_interfaces INTERFACE "${folder}/include")
    target_link_libraries(${target}_interfaces
        INTERFACE stator_${graph_executor} stator_flags stator_math stator_dronecan stator_mavlink stator_bytes)
    if(NOT graph_executor STREQUAL "replay")  # which has ports of its own, and no logger
        target_link_libraries(${target}_interfaces INTERFACE stator_log stator_parameter_port stator_machines)
    else()
        target_include_directories(${target}_interfaces INTERFACE "${CMAKE_SOURCE_DIR}/runtime/machines")
    endif()

    if(STATOR_WALLS)
        stator_add_walls(${target} "${folder}" "${graph_libraries}")
        add_dependencies(${target}_interfaces ${target}_walls)
    endif()

    # And each its own folder and ports.
    set(libraries)
    set(ports)
    foreach(entry IN LISTS graph_libraries)
        string(REGEX MATCH "^([^=]+)=([^=]+)=(.*)$" matched "${entry}")
        set(library ${target}_${CMAKE_MATCH_1})
        set(own_ports "${folder}/ports/${CMAKE_MATCH_2}")
        set(source_folder "${CMAKE_MATCH_3}")
        file(GLOB sources CONFIGURE_DEPENDS "${source_folder}/*.cpp")
        # Such a header makes a driver a part of the simulated world: the compiler looks for it.
        file(GLOB parts CONFIGURE_DEPENDS "${source_folder}/*_world.hpp")
        if(sources)
            add_library(${library} STATIC ${sources})
            target_include_directories(${library} PUBLIC "${source_folder}" "${own_ports}")
            target_link_libraries(${library} PUBLIC ${target}_interfaces)
            if(CMAKE_MATCH_1 IN_LIST graph_small_libraries)
                stator_precompile(${library} SMALL)
            else()
                stator_precompile(${library})
            endif()
        else()
            add_library(${library} INTERFACE)
            target_include_directories(${library} INTERFACE "${source_folder}" "${own_ports}")
            target_link_libraries(${library} INTERFACE ${target}_interfaces)
        endif()
        list(APPEND libraries $<LINK_ONLY:${library}>)
        list(APPEND ports "${own_ports}")
    endforeach()
    list(REMOVE_DUPLICATES ports)
    if(NOT STATOR_WALLS)  # a test's node may use another's classes, and so its ports
        target_include_directories(${target}_interfaces INTERFACE ${ports})
    endif()
    set(libraries "${libraries}" PARENT_SCOPE)
    set(ports "${ports}" PARENT_SCOPE)
endfunction()

# Apps for their unit tests, without a graph: target TARGET_APP each.
function(stator_add_apps target project apps)
    set(folder "${CMAKE_BINARY_DIR}/generated/${target}")
    list(JOIN apps "," names)
    stator_generate("${folder}" "${project}" --apps "${names}")
    stator_add_nodes(${target} "${folder}")
    stator_add_rules(${target} "" "${graph_libraries}")
endfunction()

# Everything of the graph but its board: TARGET_generated, and a target for each app and driver.
function(stator_add_graph_parts target graph board)
    set(folder "${CMAKE_BINARY_DIR}/generated/${target}")
    stator_generate("${folder}" "${graph}" --board "${board}" ${stator_gen_options})
    stator_add_nodes(${target} "${folder}")

    list(REMOVE_ITEM graph_sources ${graph_small_sources})
    list(TRANSFORM graph_sources PREPEND "${folder}/")
    list(TRANSFORM graph_small_sources PREPEND "${folder}/")
    add_library(${target}_generated OBJECT ${graph_sources})
    set(parts generated)
    if(graph_small_sources)  # of an image only
        add_library(${target}_generated_small OBJECT ${graph_small_sources})
        target_sources(${target}_generated INTERFACE $<TARGET_OBJECTS:${target}_generated_small>)
        stator_precompile(${target}_generated_small SMALL)
        list(APPEND parts generated_small)
    endif()
    stator_precompile(${target}_generated)
    # Only these and the board know apps and drivers: by "apps/NAME/NAME.hpp", as two may have a file
    # of one name. In this order, and only for names in quotes.
    set(quoted "${folder}" ${ports} ${graph_roots})
    list(TRANSFORM quoted PREPEND "-iquote")
    foreach(part IN LISTS parts)
        target_compile_options(${target}_${part} PUBLIC ${quoted})
        target_link_libraries(${target}_${part} PUBLIC ${libraries} ${target}_interfaces)
        # Headers take most of the compilation of a task, so eight files are compiled as one; each task
        # has a namespace of its own. Not where their definitions are compared.
        if(NOT STATOR_ODR)
            set_target_properties(${target}_${part} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
        endif()
    endforeach()
    stator_add_rules(${target} "$<TARGET_OBJECTS:${target}_generated>" "${graph_libraries}")
    set(graph_board "${graph_board}" PARENT_SCOPE)
    set(graph_chip "${graph_chip}" PARENT_SCOPE)
    set(graph_executor "${graph_executor}" PARENT_SCOPE)
endfunction()

function(stator_add_graph target graph board)
    stator_add_graph_parts(${target} "${graph}" "${board}")
    file(GLOB board_sources CONFIGURE_DEPENDS "${graph_board}/*.cpp")
    add_executable(${target} ${board_sources})
    target_link_libraries(${target} PRIVATE ${target}_generated)
    add_dependencies(${target} ${target}_rules)
    stator_precompile(${target})
    # What all boards with such a chip share; a board takes of it what it includes.
    file(GLOB chip_sources CONFIGURE_DEPENDS "${graph_chip}/*.cpp")
    if(graph_chip AND chip_sources)
        add_library(${target}_chip STATIC ${chip_sources})
        target_include_directories(${target}_chip PUBLIC "${graph_chip}")
        target_link_libraries(${target}_chip PUBLIC ${target}_interfaces)
        target_link_libraries(${target} PRIVATE ${target}_chip)
    endif()
    if(EXISTS "${graph_board}/board.cmake")  # what the board's code needs besides
        include("${graph_board}/board.cmake")
    endif()
    if(graph_executor STREQUAL "cortex_m")
        set(script "${CMAKE_BINARY_DIR}/generated/${target}/image.ld")
        target_link_options(${target} PRIVATE "-T${script}" "-Wl,-Map=$<TARGET_FILE:${target}>.map"
            -fcallgraph-info=su)  # the frames of all functions, for the bound of the stack
        set_target_properties(${target} PROPERTIES LINK_DEPENDS "${script}" SUFFIX ".elf")
    endif()
endfunction()
